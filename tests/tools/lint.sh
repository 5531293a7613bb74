#!/bin/sh
# Usage: lint.sh TOOL FILE...
# One of the two readers of source over these files, two at a time where it
# cannot do so itself; status 0 when it has nothing to say.
#   tidy      clang-tidy, all checks of .clang-tidy; wants compile_commands.json
#   quick     the same without the analyzer, which takes most of the time
#   cppcheck  with the list of what it says wrongly, tests/tools/cppcheck.supp
tool=$1
shift
case $tool in
cppcheck)
    exec cppcheck -j2 --quiet --error-exitcode=1 --std=c11 --max-configs=1 \
        --enable=warning,performance,portability,style --inline-suppr \
        --suppressions-list=tests/tools/cppcheck.supp \
        --template='{file}:{line}: {severity}: {message} [{id}]' \
        -D_GNU_SOURCE -D__GNUC__=12 -DGP_VERSION='""' -DGP_BRIDGE_DIR='""' \
        -Isrc "$@"
    ;;
quick) checks=-clang-analyzer-* ;;
tidy) checks= ;;
esac
# (the compiler's own warnings are gcc's; what is counted on stderr is nobody's)
printf '%s\n' "$@" | xargs -P2 -n6 clang-tidy -p . --quiet --checks="$checks" \
    --extra-arg=-Wno-everything 2>/dev/null

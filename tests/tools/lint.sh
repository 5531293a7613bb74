#!/bin/sh
# Usage: lint.sh TOOL FILE...
# Runs a linter over these files on two cores; status 0 if it finds nothing.
#   tidy      clang-tidy, all checks of .clang-tidy; needs compile_commands.json
#   quick     the same without the analyzer, which takes ten times as long as the
#             rest, and without checks that take half of the rest: that no name is
#             a reserved one, the letter case of 1L, and some of C++ alone
#   cppcheck  cppcheck, without the messages of tests/tools/cppcheck.supp
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
quick)
    checks=-clang-analyzer-*,-bugprone-reserved-identifier,-cert-dcl16-c
    checks=$checks,-bugprone-dangling-handle,-bugprone-sizeof-container
    checks=$checks,-misc-unused-using-decls
    ;;
tidy) checks= ;;
esac
# (compiler warnings are left to gcc; clang-tidy counts them on stderr)
printf '%s\n' "$@" | xargs -P2 -n16 clang-tidy -p . --quiet --checks="$checks" \
    --extra-arg=-Wno-everything 2>/dev/null

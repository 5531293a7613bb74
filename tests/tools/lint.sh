#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: lint.sh TOOL FILE...
# Runs a linter over these files; status 0 if it finds nothing.
#   clang-tidy    all checks of .clang-tidy; needs compile_commands.json
#   clang-format  .clang-format, in the lines of all C that changed since $since
#   cppcheck      without the messages of tests/tools/cppcheck.supp
since=36f4ed5c
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
clang-tidy)
    # (compiler warnings are left to gcc; clang-tidy counts them on stderr)
    printf '%s\n' "$@" | xargs -P2 -n16 clang-tidy -p . --quiet \
        --extra-arg=-Wno-everything 2>/dev/null
    ;;
clang-format)
    git rev-parse -q --verify "$since^{commit}" >/dev/null 2>&1 || {
        echo "clang-format: not run, $since is not in this clone"
        exit 0
    }
    # (older ones end with 0 whatever they find)
    found=$(git clang-format --diff --extensions c,h,cpp "$since" -- src tests examples) &&
        case $found in
        '' | 'no modified files to format' | *'did not modify any files') ;;
        *) echo "$found" && false ;;
        esac
    ;;
esac

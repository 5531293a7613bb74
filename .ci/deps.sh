#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Usage: deps.sh "PACKAGES" "EXTRA"
# Installs the Debian packages that are missing, as root or with sudo. It fails
# without PACKAGES; without EXTRA a few tests are skipped.
command -v dpkg-query >/dev/null || {
    echo "deps: this is not Debian; install the equivalents of these packages:"
    echo "$1" | fold -s
    exit 1
}

missing_of()
{
    for p in $1; do
        dpkg-query -W -f '${Status}' "$p" 2>/dev/null | grep -q 'ok installed' ||
            printf ' %s' "$p"
    done
}

missing=$(missing_of "$1") extra=$(missing_of "$2")
export DEBIAN_FRONTEND=noninteractive
sudo=
[ "$(id -u)" = 0 ] || sudo='sudo -E'
[ -z "$missing$extra" ] || $sudo apt-get update -q
if [ -n "$missing" ]; then
    echo "deps: installing$missing"
    $sudo apt-get install -q -y --no-install-recommends $missing || exit 1
fi
if [ -n "$extra" ]; then
    echo "deps: trying to install$extra"
    timeout 300 $sudo apt-get install -q -y --no-install-recommends $extra ||
        echo "deps: without$extra a few tests are skipped"
fi
exit 0

#!/bin/sh
# Usage: deb.sh TREE VERSION FOLDER
# Makes FOLDER/glarepp_VERSION_ARCH.deb of TREE, a folder in which `make
# install PREFIX=/usr` has put its files; adds what Debian asks for. Needs
# dpkg-deb and dpkg-shlibdeps (package dpkg-dev). The same tree gives the same
# bytes: all dates are that of the man page, or SOURCE_DATE_EPOCH.
set -eu
umask 022
tree=$(cd "$1" && pwd) version=$2
folder=$(cd "$3" && pwd)
root=$(cd "$(dirname "$0")/.." && pwd)
arch=$(dpkg --print-architecture)
deb=$folder/glarepp_${version}_$arch.deb
doc=$tree/usr/share/doc/glarepp
export LC_ALL=C
day=$(sed -n 's/^\.Dd //p' "$root/man/glarepp.1.in")
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(date -u -d "$day" +%s)}
export SOURCE_DATE_EPOCH
date=$(date -u -R -d "@$SOURCE_DATE_EPOCH")
maintainer="${DEBFULLNAME:-glarepp} <${DEBEMAIL:-glarepp@localhost}>"

# Debian's zsh looks for packages' completions elsewhere than make install's
mv "$tree/usr/share/zsh/site-functions" \
    "$tree/usr/share/zsh/vendor-completions"

# -- documents -----------------------------------------------------------------

gzip -9n "$tree/usr/share/man/man1/glarepp.1"
mkdir -p "$doc"
cat >"$doc/copyright" <<EOF
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: glarepp

Files: *
Copyright: the authors of glarepp
License: GPL-3+
 This program is free software: you can redistribute it and/or modify it
 under the terms of the GNU General Public License as published by the Free
 Software Foundation, either version 3 of the License, or (at your option) any
 later version.
 .
 On Debian systems the text of that license is in
 /usr/share/common-licenses/GPL-3.
EOF
gzip -9n >"$doc/changelog.gz" <<EOF
glarepp ($version) unstable; urgency=medium

  * Version $version.

 -- $maintainer  $date
EOF

# -- what it needs -------------------------------------------------------------

strip --strip-unneeded "$tree/usr/bin/glarepp" "$tree"/usr/lib/glarepp/*

# dpkg-shlibdeps reads a source package's debian/control, and takes a folder
# with DEBIAN in it as a package's
mkdir "$tree/DEBIAN"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/debian"
printf 'Source: glarepp\n\nPackage: glarepp\nArchitecture: any\n' \
    >"$work/debian/control"
depends=$(cd "$work" && dpkg-shlibdeps -O "$tree/usr/bin/glarepp" \
    "$tree"/usr/lib/glarepp/* | sed -n 's/^shlibs:Depends=//p')
[ -n "$depends" ]

# FFTW and GL are opened at run time, where nothing sees them; without GL the
# engine splat and the mask of the sun are missing, all else is there
cat >"$tree/DEBIAN/control" <<EOF
Package: glarepp
Version: $version
Architecture: $arch
Maintainer: $maintainer
Installed-Size: $(du -k -s --apparent-size "$tree/usr" | cut -f1)
Depends: $depends, libfftw3-double3, libfftw3-single3
Recommends: libosmesa6 | libegl1
Suggests: gnuplot
Section: graphics
Priority: optional
Description: add the glare of bright light to HDR frames
 glarepp reads scene-linear OpenEXR frames, adds the glare that bright light
 makes in an eye or a lens, with the sun hidden behind what stands in front of
 it, and writes tone-mapped pictures and scene-linear frames. It needs no
 display, and says how fast and how wrong it was.
EOF
(cd "$tree" && find usr -type f | sort | xargs md5sum >DEBIAN/md5sums)
find "$tree" -newermt "@$SOURCE_DATE_EPOCH" -exec \
    touch -h -d "@$SOURCE_DATE_EPOCH" {} +
dpkg-deb --root-owner-group -Zxz --build "$tree" "$deb"

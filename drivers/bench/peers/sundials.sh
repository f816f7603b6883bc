#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# sundials.sh PREFIX: SUNDIALS from Debian's own source package, compiled with optimisation, static, into PREFIX.
#
# The packages of Debian 12 (6.4.1+dfsg1-3) are compiled without: debian/rules passes -DCMAKE_C_FLAGS=-fcommon, which replaces the flags of
# the packaging with its -O2. Where the source cannot be had the script says so and ends with status 1; the peers then use the packages
# (-O0), and no ratio to them is worth quoting.
set -euo pipefail
prefix=$(realpath -m "${1:?usage: sundials.sh PREFIX}")
[ ! -e "$prefix/lib/libsundials_cvode.a" ] || exit 0
work=$prefix.work
mkdir -p "$work/lists/partial" "$work/archives/partial"
cd "$work"

# Lists of its own, so that the sources of the system are left alone.
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
. /etc/os-release
cat >debian.sources <<END
Types: deb-src
URIs: http://deb.debian.org/debian
Suites: ${VERSION_CODENAME:-bookworm}
Components: main
Signed-By: $keyring
END
apt() {
  apt-get -qq -o Dir::Etc::sourcelist="$work/debian.sources" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$work/lists" \
    -o Dir::Cache::archives="$work/archives" -o Dir::Cache::pkgcache= -o Dir::Cache::srcpkgcache= "$@"
}
if ! ls -d sundials-*/ >/dev/null 2>&1; then
  if ! { apt update && apt source sundials; } >apt.log 2>&1; then
    echo "sundials.sh: Debian's source package cannot be fetched; see $work/apt.log" >&2
    exit 1
  fi
fi
source=$(ls -d "$work"/sundials-*/ | head -1)
cmake -S "$source" -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS=-march=native -DCMAKE_C_FLAGS_RELEASE="-O3 -DNDEBUG" \
  -DBUILD_SHARED_LIBS=OFF -DBUILD_CVODES=OFF -DBUILD_IDA=OFF -DBUILD_IDAS=OFF -DBUILD_KINSOL=OFF \
  -DEXAMPLES_ENABLE_C=OFF -DEXAMPLES_ENABLE_CXX=OFF -DEXAMPLES_INSTALL=OFF -DCMAKE_INSTALL_PREFIX="$prefix" >cmake.log 2>&1
ninja -C build -j2 install >ninja.log 2>&1
echo "sundials.sh: $(basename "$source") with -O3 -march=native in $prefix"

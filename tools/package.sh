#!/usr/bin/env bash
# Builds Debian packages of sluice into out/packages: sluice, sluice-window, sluice-mpi, libsluice0.1,
# libsluice-dev and python3-sluice. DEBFULLNAME and DEBEMAIL name who makes them, as for Debian's own tools; without
# them, git's user does.
# JOBS limits the compilers that run at once.
#   tools/package.sh [OPTION...]      options go to `cmake --preset batches`
set -euo pipefail
cd "$(dirname "$0")/.."

tools/setup.sh build
name=${DEBFULLNAME:-$(git config user.name || true)}
address=${DEBEMAIL:-$(git config user.email || true)}
if [[ -z $name || -z $address ]]; then
  echo "package.sh: nobody to name as the packager; set DEBFULLNAME and DEBEMAIL" >&2
  exit 1
fi
# Files of the same sources are the same, whenever they are made.
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
umask 022

build=build/package
cmake --preset batches -B "$build" -DBUILD_TESTING=OFF -DCMAKE_INSTALL_PREFIX=/usr -DSLUICE_PACKAGES=ON \
  -DSLUICE_PACKAGER="$name <$address>" "$@" >/dev/null
cmake --build "$build" -j "${JOBS:-$(nproc)}"
mkdir -p out/packages
rm -f out/packages/*.deb
(cd "$build" && cpack -G DEB -B "$PWD/debs" >/dev/null)
mv "$build"/debs/*.deb out/packages/
rm -rf "$build/debs"
ls -l out/packages

#!/usr/bin/env bash
# Packs the Python package of a build into out/wheels, as a wheel that pip installs into an environment of
# yours. It holds sluice and its readers. The libraries that these need are Debian 12's: install them with
# `tools/setup.sh build`. Needs Debian's python3-wheel.
#   tools/wheel.sh [BUILD_FOLDER [WHEEL_FOLDER]]      build/release and out/wheels by default
set -euo pipefail
top=$(cd "$(dirname "$0")/.." && pwd)
build=${1-$top/build/release}
wheels=${2-$top/out/wheels}
/usr/bin/python3 -m wheel version >/dev/null 2>&1 ||
  { echo "wheel.sh: python3-wheel is not installed (apt-get install python3-wheel)" >&2; exit 1; }
[[ -e $build/python/sluice/__init__.py ]] ||
  { echo "wheel.sh: $build: expected a build of sluice with its Python package, found none; build it first" >&2; exit 1; }
if grep -q '^SLUICE_KERNEL_SETS:[A-Z]*=NATIVE$' "$build/CMakeCache.txt"; then
  echo "wheel.sh: $build draws on processors like this one alone; build it with \`cmake --preset release\`" >&2
  exit 1
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build" --prefix "$work/prefix" >/dev/null
mkdir "$work/wheel"
cp -r "$work/prefix/lib/python3/dist-packages/sluice" "$work/wheel/sluice"
# Readers lie beside the extension module, where it looks first.
for reader in openvdb hdf5 dicom web; do
  find "$work/prefix" -name "sluice_$reader.so" -exec cp {} "$work/wheel/sluice/" \;
done

version=$("$build/sluice" --version | awk '{ print $NF }')
information=$work/wheel/sluice-$version.dist-info
mkdir "$information"
cp "$top/LICENSE" "$information/"
cat >"$information/METADATA" <<END
Metadata-Version: 2.1
Name: sluice
Version: $version
Summary: Renders scalar volumes that are larger than memory
License: Apache-2.0
License-File: LICENSE
Requires-Python: >=3.11
Requires-Dist: numpy
END
tag=$(/usr/bin/python3 -c 'import sys, sysconfig
python = "cp%d%d" % sys.version_info[:2]
print(f"{python}-{python}-" + sysconfig.get_platform().replace("-", "_").replace(".", "_"))')
cat >"$information/WHEEL" <<END
Wheel-Version: 1.0
Generator: sluice
Root-Is-Purelib: false
Tag: $tag
END
mkdir -p "$wheels"
/usr/bin/python3 -m wheel pack "$work/wheel" --dest-dir "$wheels" >/dev/null
ls "$wheels"/sluice-"$version"-"$tag".whl

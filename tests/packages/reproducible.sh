#!/usr/bin/env bash
# Builds the packages of the last commit twice, from nothing, in two folders, and compares their bytes. The second
# time has another umask, time zone, number of compilers and depth of folders. Takes two builds without a cache, so
# that no suite runs it.
#   tests/packages/reproducible.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
source=$PWD

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export CCACHE_DISABLE=1 DEBFULLNAME=Sluice DEBEMAIL=sluice@example.org
first=$folder/first second=$folder/somewhere/else/second
for clone in "$first" "$second"; do git clone -q "$source" "$clone"; done
(umask 022 && TZ=UTC JOBS=2 "$first/tools/package.sh" >"$folder/first.txt" 2>&1) ||
  { tail "$folder/first.txt"; exit 1; }
(umask 077 && TZ=Asia/Tokyo JOBS=3 "$second/tools/package.sh" >"$folder/second.txt" 2>&1) ||
  { tail "$folder/second.txt"; exit 1; }

differ=0
for package in "$first"/out/packages/*.deb; do
  name=$(basename "$package")
  if cmp "$package" "$second/out/packages/$name"; then
    echo "the same: $name"
  else
    differ=1
  fi
done
exit $differ

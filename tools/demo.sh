#!/usr/bin/env bash
# Installs what is needed, builds, and draws a volume: the one named, or a Shepp-Logan head that is
# made on the spot. More options go to `sluice render` as they are:
#   tools/demo.sh [FILE [OPTION...]]
set -euo pipefail
cd "$(dirname "$0")/.."
caller=$OLDPWD

tools/setup.sh
cmake --preset release >/dev/null
cmake --build --preset release --target sluice

mkdir -p out
picture=$PWD/out/picture.png
sluice=$PWD/build/release/sluice
if (($# > 0)); then
  cd "$caller"
  "$sluice" render "$@" -o "$picture"
else
  "$sluice" synth phantom --dims 256,256,256 -o out/phantom.raw
  "$sluice" render out/phantom_256x256x256_uint8.raw -o "$picture" --threshold 30 --opacity 0.3 --shade \
    --step 0.5 --azimuth 125 --elevation 28 --zoom 1.3 --crop 0,0,0,256,128,256
fi
echo "The picture is $picture"

#!/usr/bin/env bash
# Installs what building and drawing need, builds the program without its tests, and draws a volume:
# the one named, or a Shepp-Logan head, cut open. More options go to `sluice render`
# as they are:
#   tools/demo.sh [FILE [OPTION...]]
# Then builds what no first picture needs: the window, the reader of OpenVDB, ranks, and the library for other
# programs. `cmake --install build/release` works after it. The CPU device has the instructions of this
# processor alone: the preset release builds it for others, too.
set -euo pipefail
cd "$(dirname "$0")/.."
caller=$OLDPWD
mkdir -p out

tools/setup.sh picture
# What the modules need comes after the picture: unpacking it takes both processors, as compiling does.
add_modules() {
  tools/setup.sh build
  cmake --preset demo -DSLUICE_VDB=ON >/dev/null
}
# Sources are compiled in batches, for half of the time. `cmake --preset release` compiles each by
# itself again, as one does who edits them, and brings the tests back.
cmake --preset demo -DSLUICE_VDB=OFF >/dev/null
cmake --build --preset demo

picture=$PWD/out/picture.png
sluice=$PWD/build/release/sluice
if (($# > 0)); then
  # A module may be what reads the file.
  add_modules
  cmake --build --preset demo --target sluice_modules
  cd "$caller"
  "$sluice" render "$@" -o "$picture"
  cd "$OLDPWD"
else
  "$sluice" render synth:phantom,dims=256x256x256 -o "$picture" --crop 0,0,0,256,128,256 \
    --opacity 0.1 --annotate
fi
echo "The picture is $picture"

echo "Building the rest: the window, OpenVDB, ranks, the library"
add_modules
cmake --build build/release

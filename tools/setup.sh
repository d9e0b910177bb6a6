#!/usr/bin/env bash
# Installs what sluice needs on Debian 12, as root or through sudo. Quick and quiet when it is there.
#   tools/setup.sh picture   what building the program and drawing need
#   tools/setup.sh build     what its modules need, too: OpenVDB, DICOM, HDF5, the web, ranks, the window, Python
#   tools/setup.sh           what the tests and gates need, too
set -euo pipefail

picture_packages=(
  g++ cmake ninja-build pkg-config
  libopenexr-dev libosmesa6-dev libegl-dev libgl-dev
  libblosc-dev libzstd-dev libcli11-dev libfmt-dev nlohmann-json3-dev libpng-dev libtiff-dev zlib1g-dev
  libcairo2-dev libxxhash-dev libhwy-dev libexpat1-dev liblz4-dev liblzma-dev
  # To write in pictures.
  fonts-dejavu-core
)
build_packages=(
  libopenvdb-dev libboost-dev libtbb-dev libcurl4-openssl-dev libgdcm-dev libhdf5-dev
  # Pictures by several ranks; libmpich-dev in its place, or beside it, does as well.
  libopenmpi-dev
  # The window's module; without these the rest is built all the same.
  libglfw3-dev libimgui-dev libstb-dev
  # The Python package; without these the rest is built all the same.
  python3-dev python3-numpy pybind11-dev
  # To draw with OpenGL.
  libosmesa6 libegl1 libegl-mesa0 libgl1-mesa-dri
)
test_packages=(
  ccache libgtest-dev libgmock-dev
  # Ranks under both MPIs, and over hosts that are network namespaces.
  openmpi-bin mpich libmpich-dev iproute2
  # A server that speaks HTTP/2, and a certificate for it.
  nghttp2-server openssl
  # Sanitizers, gates, and the programs of others that results are checked against.
  clang clang-format clang-tidy libclang-rt-14-dev
  xvfb xdotool libxtst6 tidy
  libopenvdb-tools nifti-bin teem-apps openexr openimageio-tools python3-openimageio ffmpeg
  python3 python3-numpy python3-h5py python3-vtk9 python3-nibabel python3-tifffile python3-zarr python3-numcodecs python3-pil
  libgdcm-tools python3-pydicom python3-gdcm
  # The Python package as a wheel, and an environment to install it into.
  python3-wheel python3-venv
  # Manual pages, completions, the desktop's files.
  man-db groff mandoc zsh fish desktop-file-utils shared-mime-info libxml2-utils
  # The documents and the library's headers as pages.
  mkdocs doxygen
  # The library's binary interface; what Python's examples and tests take with it.
  abigail-tools python3-matplotlib python3-ipywidgets python3-dask python3-xarray python3-pandas
)

case "${1-all}" in
  picture) packages=("${picture_packages[@]}") ;;
  build) packages=("${picture_packages[@]}" "${build_packages[@]}") ;;
  all) packages=("${picture_packages[@]}" "${build_packages[@]}" "${test_packages[@]}") ;;
  *) echo "setup.sh: expected 'picture', 'build' or nothing, found '$1'" >&2; exit 2 ;;
esac

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
((${#missing[@]} == 0)) && exit 0

as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || { echo "setup.sh: not root and no sudo; install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "Installing ${#missing[@]} packages: ${missing[*]}"
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${missing[@]}"

// Volumes of arrays in Python's memory. An array is indexed [z, y, x], or [time, z, y, x] with
// several steps; places and lengths are x, y, z.
#pragma once

#include <pybind11/numpy.h>
#include <sluice/volume.h>

#include <array>
#include <string>

namespace sluice::python {

namespace py = pybind11;

using Triple = std::array<double, 3>;

struct ArrayPlace {
  Triple spacing{1, 1, 1}, origin{0, 0, 0};
  std::string unit, name;
};

// The layout of an array of this shape and type. Throws ValueError for another number of axes or no
// voxel, and TypeError for a type that no volume has.
ArrayLayout layoutOf(const std::vector<int64_t>& shape, const py::dtype& type,
                     const ArrayPlace& place);

// The voxels of `array` as they are, whatever its strides, also if it is read-only. Nothing is
// copied; the array must outlive the volume. Throws as layoutOf() does, and Error.
Volume borrowed(const py::array& array, const ArrayPlace& place, const VolumeOptions& options,
                const ProgressFunction& progress);

// Voxels that fill(time, lo, hi) gives as an array of the box's shape [z, y, x] and of the type;
// lo and hi are x, y, z, and hi is not included. Threads of the library call, one at a time in
// Python. Throws as borrowed() does; what `fill` raises ends the call that needs the voxels.
Volume filled(py::function fill, const std::vector<int64_t>& shape, const py::dtype& type,
              const ArrayPlace& place, const VolumeOptions& options,
              const ProgressFunction& progress);

}  // namespace sluice::python

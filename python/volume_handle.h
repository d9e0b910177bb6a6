// An open volume as Python holds it, and arrays of numbers for Python.
#pragma once

#include <pybind11/numpy.h>
#include <sluice/volume.h>

#include <memory>
#include <utility>
#include <vector>

#include "python/running.h"

namespace sluice::python {

// An open volume, and the array that it borrows.
struct VolumeHandle {
  py::object array;
  Held<Volume> volume;
};

// A NumPy array that owns `values`, packed, of this shape.
template <class T>
py::array_t<T> arrayOf(std::vector<T> values, const std::vector<py::ssize_t>& shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  const T* const first = kept->data();
  const py::capsule owner(kept.release(),
                          [](void* held) { delete static_cast<std::vector<T>*>(held); });
  return py::array_t<T>(shape, first, owner);
}

}  // namespace sluice::python

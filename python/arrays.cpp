#include "python/arrays.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <bit>
#include <cstring>
#include <memory>
#include <utility>

#include "python/running.h"

namespace sluice::python {
namespace {

std::string nameOf(const py::dtype& type) {
  return py::str(py::handle(type)).cast<std::string>();
}

// The conversion of an array of this type to numbers that can be drawn.
std::string conversionOf(const py::dtype& type) {
  if (type.has_fields()) {
    const auto names = type.attr("names").cast<std::vector<std::string>>();
    return fmt::format("give one field, as array['{}']", names.front());
  }
  if (type.kind() == 'c') return "give one part of them, as numpy.abs(array)";
  if (type.kind() == 'M' || type.kind() == 'm')
    return "convert them, as with (array - array.min()) / numpy.timedelta64(1, 's')";
  return "convert them, as with array.astype('float32')";
}

// "u8" for NumPy's uint8. Truth values are bytes.
std::string typeOf(const py::dtype& type) {
  constexpr std::string_view kKinds = "buif";
  const char kind = type.kind();
  const auto bytes = static_cast<int>(type.itemsize());
  const bool is_number = kKinds.find(kind) != std::string_view::npos;
  const bool is_float = kind == 'f';
  if (!is_number || bytes > 8 || (is_float && bytes < 4) || (!is_float && bytes > 4))
    throw py::type_error(
        fmt::format("voxels are whole numbers of 8, 16 or 32 bits or floats of 32 or 64 bits, "
                    "found {}; {}",
                    nameOf(type), conversionOf(type)));
  if (!type.attr("isnative").cast<bool>())
    throw py::type_error(
        fmt::format("voxels are in this machine's byte order, found {}; convert them with "
                    "array.astype(array.dtype.newbyteorder('='))",
                    nameOf(type)));
  return fmt::format("{}{}", kind == 'b' ? 'u' : kind, 8 * bytes);
}

}  // namespace

ArrayLayout layoutOf(const std::vector<int64_t>& shape, const py::dtype& type,
                     const ArrayPlace& place) {
  if (shape.size() != 3 && shape.size() != 4)
    throw py::value_error(fmt::format(
        "expected an array indexed [z, y, x] or [time, z, y, x], found {} axes", shape.size()));
  for (const int64_t extent : shape)
    if (extent < 1)
      throw py::value_error(
          fmt::format("expected at least one voxel along each axis, found the shape ({})",
                      fmt::join(shape, ", ")));
  const size_t z = shape.size() - 3;
  return {.dims = {shape[z + 2], shape[z + 1], shape[z]},
          .type = typeOf(type),
          .time_steps = z == 0 ? 1 : shape[0],
          .spacing = place.spacing,
          .origin = place.origin,
          .unit = place.unit,
          .name = place.name};
}

Volume borrowed(const py::array& array, const ArrayPlace& place, const VolumeOptions& options,
                const ProgressFunction& progress) {
  const std::vector<int64_t> shape(array.shape(), array.shape() + array.ndim());
  const ArrayLayout layout = layoutOf(shape, array.dtype(), place);
  const size_t z = shape.size() - 3;
  const ArrayStrides strides{array.strides(z + 2), array.strides(z + 1), array.strides(z),
                             z == 0 ? 0 : array.strides(0)};
  const void* const first = array.data();
  return run([&](const std::stop_token& stop) {
    return Volume::borrow(first, layout, strides, options, progress, stop);
  });
}

Volume filled(py::function fill, const std::vector<int64_t>& shape, const py::dtype& type,
              const ArrayPlace& place, const VolumeOptions& options,
              const ProgressFunction& progress) {
  const ArrayLayout layout = layoutOf(shape, type, place);
  const FillBox box = [call = sharedFunction(std::move(fill)), voxel_bytes = type.itemsize()](
                          int64_t time, const std::array<int64_t, 3>& lo,
                          const std::array<int64_t, 3>& hi, std::span<std::byte> out) {
    const py::gil_scoped_acquire locked;
    const auto voxels = (*call)(time, lo, hi).cast<py::array>();
    const bool is_packed = (voxels.flags() & py::array::c_style) != 0;
    if (voxels.itemsize() != voxel_bytes || static_cast<size_t>(voxels.nbytes()) != out.size() ||
        !is_packed)
      throw py::value_error(fmt::format(
          "the function gave {} bytes in voxels of {} for a box of {} x {} x {} voxels of {} "
          "bytes; "
          "expected a contiguous array of the box's shape (z, y, x) and of the volume's type",
          voxels.nbytes(), voxels.itemsize(), hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2],
          voxel_bytes));
    std::memcpy(out.data(), voxels.data(), out.size());
  };
  return run([&](const std::stop_token& stop) {
    return Volume::fromFunction(box, layout, options, progress, stop);
  });
}

}  // namespace sluice::python

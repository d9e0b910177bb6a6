#include "io/zarr/metadata/zarr_array_fields.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "src/base/error.h"
#include "src/base/sources/volume_source.h"

namespace sluice {
namespace {

// nullopt when the product is beyond `most`.
std::optional<int64_t> product(const std::vector<int64_t>& factors, int64_t most) {
  int64_t result = 1;
  for (const int64_t factor : factors)
    if (__builtin_mul_overflow(result, factor, &result) || result > most) return std::nullopt;
  return result;
}

// "0x7fc00000": the bits of a number.
std::optional<uint64_t> hexBits(const std::string& text) {
  if (!text.starts_with("0x")) return std::nullopt;
  uint64_t bits = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + 2, end, bits, 16);
  return error == std::errc() && stop == end ? std::optional(bits) : std::nullopt;
}

double floatFill(const JsonField& field, VoxelType type) {
  if (!field.isText()) return field.number();
  const std::string& text = field.text();
  if (text == "NaN") return std::numeric_limits<double>::quiet_NaN();
  if (text == "Infinity") return std::numeric_limits<double>::infinity();
  if (text == "-Infinity") return -std::numeric_limits<double>::infinity();
  if (const auto bits = hexBits(text)) {
    // The number of digits tells the length that the writer meant.
    if (type == VoxelType::kF32 && text.size() == 10)
      return double{std::bit_cast<float>(static_cast<uint32_t>(*bits))};
    if (type == VoxelType::kF64 && text.size() == 18) return std::bit_cast<double>(*bits);
  }
  field.failExpected("a number, NaN, Infinity or -Infinity, or all bits of one as 0x7fc00000");
}

}  // namespace

std::vector<int64_t> zarrExtents(const JsonField& field) {
  const size_t axes = field.size();
  if (axes < 1 || axes > kMostZarrAxes) field.failExpected("the extents of 1 to 5 axes");
  std::vector<int64_t> found;
  for (size_t a = 0; a < axes; ++a) {
    found.push_back(field[a].whole());
    if (found.back() < 1) field[a].failExpected("an extent of 1 or more");
  }
  return found;
}

std::vector<int64_t> zarrExtents(const JsonField& field, const ZarrArray& array) {
  std::vector<int64_t> found = zarrExtents(field);
  if (found.size() != array.axes())
    field.failExpected(fmt::format("{} extents, as in shape", array.axes()));
  return found;
}

void requireZarrSizes(const JsonField& shape, const JsonField& chunks, const ZarrArray& array) {
  if (!product(array.shape, kMostVolumeVoxels)) shape.failExpected("at most 2^59 voxels");
  const auto most = static_cast<int64_t>(kMostChunkBytes / bytesPerVoxel(array.type));
  if (!product(array.chunks, most))
    chunks.failExpected(fmt::format("at most {} voxels a chunk", most));
}

double zarrFill(const JsonField& field, const ZarrArray& array) {
  // Zarr 2: null leaves the values of missing chunks open.
  if (field.isNull()) return 0;
  return visitVoxelType(array.type, [&](auto tag) -> double {
    using T = decltype(tag);
    if constexpr (std::is_floating_point_v<T>) {
      const double value = floatFill(field, array.type);
      if (std::isfinite(value) && std::abs(value) > double{std::numeric_limits<T>::max()})
        field.failExpected("a fill value that the type holds");
      // A 32-bit float cannot hold all digits of the text; voxels hold the rounded value.
      return static_cast<double>(static_cast<T>(value));
    } else {
      // false and true of a bool array; texts are of floats alone.
      const double value = field.isFlag() ? (field.flag() ? 1.0 : 0.0) : field.number();
      if (!(value >= double{std::numeric_limits<T>::min()} &&
            value <= double{std::numeric_limits<T>::max()}) ||
          value != std::floor(value))
        field.failExpected("a fill value that the type holds");
      return value;
    }
  });
}

}  // namespace sluice

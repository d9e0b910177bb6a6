#include "io/dicom/dicom_pixels.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "io/files/luminance.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// The number that a word stands for: its stored bits, with their sign.
template <class T>
T numberIn(T word, const DicomPixelForm& form) {
  if constexpr (std::is_integral_v<T>) {
    const int shift_down = static_cast<int>(form.high_bit + 1 - form.bits_stored);
    const int shift_up = static_cast<int>(form.bits_allocated - 1 - form.high_bit);
    if (shift_down == 0 && shift_up == 0) return word;
    using Unsigned = std::make_unsigned_t<T>;
    // Up to the top, so that what lies above leaves, and down with the sign.
    const auto at_top = static_cast<T>(static_cast<Unsigned>(word) << shift_up);
    return static_cast<T>(at_top >> (shift_up + shift_down));
  }
  return word;
}

template <class T>
T wordAt(const std::byte* at, bool is_swapped) {
  std::byte bytes[sizeof(T)];
  std::memcpy(bytes, at, sizeof(T));
  if (is_swapped) std::reverse(bytes, bytes + sizeof(T));
  T word;
  std::memcpy(&word, bytes, sizeof(T));
  return word;
}

template <class T, class Out>
Out valueOf(T number, const std::optional<DicomLine>& line) {
  if constexpr (std::is_same_v<T, Out>) {
    if (!line) return number;
  }
  const double value = line->slope * static_cast<double>(number) + line->intercept;
  if constexpr (std::is_integral_v<Out>)
    return static_cast<Out>(std::lround(value));
  else
    return static_cast<Out>(value);
}

template <class T, class Out>
void convert(const DicomPixelForm& form, const DicomPixels& pixels,
             const std::optional<DicomLine>& line, int64_t count, std::span<std::byte> out) {
  const std::byte* from = pixels.bytes.data();
  for (int64_t i = 0; i < count; ++i, from += pixels.pixel_bytes) {
    T number = numberIn(wordAt<T>(from, pixels.is_swapped), form);
    if constexpr (std::is_same_v<T, uint8_t>) {
      if (form.samples == 3 && !form.has_luminance)
        number = luminance(number, wordAt<T>(from + pixels.color_bytes, false),
                           wordAt<T>(from + 2 * pixels.color_bytes, false));
    }
    const Out value = valueOf<T, Out>(number, line);
    std::memcpy(out.data() + i * static_cast<int64_t>(sizeof(Out)), &value, sizeof(Out));
  }
}

}  // namespace

DicomPixelForm dicomPixelForm(const DicomHeader& h) {
  return {.columns = h.columns,
          .rows = h.rows,
          .samples = h.samples,
          .bits_allocated = h.bits_allocated,
          .bits_stored = h.is_float ? h.bits_allocated : h.bits_stored,
          .high_bit = h.is_float ? h.bits_allocated - 1 : h.high_bit,
          .is_signed = h.is_signed,
          .is_float = h.is_float,
          .has_luminance = h.photometric == "YBR_FULL"};
}

VoxelType storedDicomType(const DicomPixelForm& form) {
  if (form.is_float) return form.bits_allocated == 64 ? VoxelType::kF64 : VoxelType::kF32;
  if (form.bits_allocated == 8) return form.is_signed ? VoxelType::kI8 : VoxelType::kU8;
  if (form.bits_allocated == 16) return form.is_signed ? VoxelType::kI16 : VoxelType::kU16;
  return form.is_signed ? VoxelType::kI32 : VoxelType::kU32;
}

DicomRange storedDicomRange(const DicomPixelForm& form) {
  const double count = std::ldexp(1, static_cast<int>(form.bits_stored));
  return form.is_signed ? DicomRange{-count / 2, count / 2 - 1} : DicomRange{0, count - 1};
}

void convertDicomPixels(const DicomPixelForm& form, const DicomPixels& pixels,
                        const std::optional<DicomLine>& line, VoxelType type, int64_t count,
                        std::span<std::byte> out) {
  visitVoxelType(storedDicomType(form), [&](auto tag) {
    using T = decltype(tag);
    if (!line)
      convert<T, T>(form, pixels, line, count, out);
    else if (type == VoxelType::kI16)
      convert<T, int16_t>(form, pixels, line, count, out);
    else
      convert<T, float>(form, pixels, line, count, out);
  });
}

}  // namespace sluice

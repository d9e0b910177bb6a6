// From a DICOM file's pixels to voxels: bits within words, byte orders, colors, and the straight
// line from stored numbers to values. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "io/dicom/dicom_header.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

// How the pixels of a frame are stored. Equal for all slices of a stack.
struct DicomPixelForm {
  int64_t columns = 0, rows = 0, samples = 1;
  int64_t bits_allocated = 8, bits_stored = 8, high_bit = 7;
  bool is_signed = false, is_float = false;
  // Luminance and two differences of color; otherwise three colors.
  bool has_luminance = false;
  friend bool operator==(const DicomPixelForm&, const DicomPixelForm&) = default;

  int64_t pixelBytes() const { return samples * (bits_allocated / 8); }
  int64_t frameBytes() const { return columns * rows * pixelBytes(); }
};
DicomPixelForm dicomPixelForm(const DicomHeader& header);

// The type of the stored numbers.
VoxelType storedDicomType(const DicomPixelForm& form);
// The range of numbers of that many bits.
struct DicomRange {
  double lo = 0, hi = 0;
};
DicomRange storedDicomRange(const DicomPixelForm& form);

// value = slope * stored + intercept.
struct DicomLine {
  double slope = 1, intercept = 0;
  friend bool operator==(const DicomLine&, const DicomLine&) = default;
};

// How a run of pixels lies in memory.
struct DicomPixels {
  std::span<const std::byte> bytes = {};
  bool is_swapped = false;  // the other byte order than this machine's
  int64_t color_bytes = 0;  // from one color of a pixel to the next
  int64_t pixel_bytes = 0;  // from one pixel to the next
};

// Converts `count` pixels to voxels of `type`, which is storedDicomType() without a line, and 16
// bit integers or 32 bit floats with one.
void convertDicomPixels(const DicomPixelForm& form, const DicomPixels& pixels,
                        const std::optional<DicomLine>& line, VoxelType type, int64_t count,
                        std::span<std::byte> out);

}  // namespace sluice

// VolumeDescription: the contents of a volume's header, and the checks that every header goes
// through.
//
// The parsers of the text and binary headers (nrrd_header, meta_image_header, nifti_header) fill
// one; openDescribed (described_volume.h) looks at the data files. Nothing here touches a file, so
// that parsers can be fuzzed.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/headers/file_set.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// Keeps sums of skips and sizes far from overflow.
constexpr int64_t kMostSkipBytes = int64_t{1} << 60;

enum class Encoding { kRaw, kDeflate, kText };

struct VolumeDescription {
  VolumeLayout layout;  // all but the name
  std::endian byte_order = std::endian::little;
  Encoding encoding = Encoding::kRaw;
  FileSet files;             // names are relative to the header's folder
  uint64_t data_offset = 0;  // attached data: where they start in the header's file
  int64_t line_skip = 0;     // lines to leave out in front of the data of each file
  int64_t byte_skip = 0;     // then bytes, decoded ones if encoded; kSkipToEnd
  // The data are the last bytes of the file.
  static constexpr int64_t kSkipToEnd = -1;
};

// Bytes of all voxels of all time steps. Throws Error, which starts with `path`, when a dimension
// is below 1 or the bytes do not fit 2^62.
int64_t checkedVolumeBytes(const std::string& path, const VolumeLayout& layout);

// "256 x 256 x 128 x 1 byte (u8) + 0 skipped = 8388608 bytes"; with time steps, if there are
// several, as a fourth factor. `files` > 1: the bytes are divided evenly among them. Requires: the
// layout is checked.
std::string sizeArithmetic(const VolumeLayout& layout, int64_t skipped, int64_t files = 1);

// Sets spacing and axes from the world vectors between neighbouring voxels, x first; those that a
// header of fewer dimensions lacks become unit steps perpendicular to the others. The axes need
// not be perpendicular, but Throws Error when one is not finite, outside 1e-30 to 1e30, or when
// they lie in a plane.
void setSteps(const std::string& path, std::vector<Vec3d> steps, VolumeLayout& layout);

// A line for people if one of the spacings in a file is negative, which turns its axis round;
// empty: none is. `path`: the file's.
std::string negativeSpacingNote(const std::string& path, std::span<const double> spacing);

// Throws Error unless finite and within 1e30.
void setOrigin(const std::string& path, Vec3d origin, VolumeLayout& layout);

// Throws Error when lo is above hi; ignores both when one is not within 1e100 (headers write "nan",
// or the greatest number there is, for unknown).
void setStoredRange(const std::string& path, double lo, double hi, VolumeLayout& layout);

// value = stored * scale + offset. Throws Error unless both are within 1e100 and the scale is
// 1e-100 or more, either sign: every value is then finite.
void setValueScale(const std::string& path, double scale, double offset, VolumeLayout& layout);

}  // namespace sluice

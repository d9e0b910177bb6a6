#include "io/headers/nifti/nifti_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kNifti1Bytes = 348;
// A file of header and voxels has four bytes between them that announce extensions.
constexpr size_t kExtensionFlagBytes = 4;

// Numbers at byte offsets, in the byte order that the first of them shows.
class Reader {
 public:
  Reader(std::span<const std::byte> bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}

  template <class T>
  T at(size_t offset) const {
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
    if (swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  std::string_view text(size_t offset, size_t length) const {
    return {reinterpret_cast<const char*>(bytes_.data()) + offset, length};
  }
  // NIfTI-1 has T1 for fields that have the wider T2 in NIfTI-2.
  template <class T1, class T2>
  T2 either(bool second, size_t offset1, size_t offset2) const {
    return second ? at<T2>(offset2) : static_cast<T2>(at<T1>(offset1));
  }

 private:
  const std::span<const std::byte> bytes_;
  const bool swapped_;
};

// The fields that both versions have, widened; names as in the standard.
struct NiftiFields {
  std::string magic;
  size_t header_bytes = 0;
  int16_t datatype = 0, bitpix = 0;
  std::array<int64_t, 8> dim{};
  std::array<double, 8> pixdim{};
  double toffset = 0;
  double vox_offset = 0;  // a whole number in NIfTI-2
  double scl_slope = 0, scl_inter = 0;
  int64_t qform_code = 0, sform_code = 0;
  int64_t xyzt_units = 0;
  std::array<double, 3> quatern{}, qoffset{};
  std::array<std::array<double, 4>, 3> srow{};
};

NiftiFields readFields(const Reader& r, bool second) {
  NiftiFields f;
  f.header_bytes = second ? kNiftiHeaderBytes : kNifti1Bytes;
  f.magic = second ? r.text(4, 8) : r.text(344, 4);
  f.datatype = r.at<int16_t>(second ? 12 : 70);
  f.bitpix = r.at<int16_t>(second ? 14 : 72);
  for (size_t i = 0; i < 8; ++i) {
    f.dim[i] = r.either<int16_t, int64_t>(second, 40 + 2 * i, 16 + 8 * i);
    f.pixdim[i] = r.either<float, double>(second, 76 + 4 * i, 104 + 8 * i);
  }
  f.vox_offset = second ? static_cast<double>(r.at<int64_t>(168)) : r.at<float>(108);
  f.scl_slope = r.either<float, double>(second, 112, 176);
  f.scl_inter = r.either<float, double>(second, 116, 184);
  f.toffset = r.either<float, double>(second, 136, 216);
  f.qform_code = r.either<int16_t, int32_t>(second, 252, 344);
  f.xyzt_units = second ? r.at<int32_t>(500) : r.at<int8_t>(123);
  f.sform_code = r.either<int16_t, int32_t>(second, 254, 348);
  for (size_t i = 0; i < 3; ++i) {
    f.quatern[i] = r.either<float, double>(second, 256 + 4 * i, 352 + 8 * i);
    f.qoffset[i] = r.either<float, double>(second, 268 + 4 * i, 376 + 8 * i);
    for (size_t j = 0; j < 4; ++j)
      f.srow[i][j] = r.either<float, double>(second, 280 + 16 * i + 4 * j, 400 + 32 * i + 8 * j);
  }
  return f;
}

int32_t firstNumber(std::span<const std::byte> bytes, bool swapped) {
  return Reader(bytes, swapped).at<int32_t>(0);
}

VoxelType voxelType(const NiftiFields& f, const std::string& path) {
  constexpr std::array<std::pair<int, VoxelType>, 8> kTypes = {{{2, VoxelType::kU8},
                                                                {256, VoxelType::kI8},
                                                                {512, VoxelType::kU16},
                                                                {4, VoxelType::kI16},
                                                                {768, VoxelType::kU32},
                                                                {8, VoxelType::kI32},
                                                                {16, VoxelType::kF32},
                                                                {64, VoxelType::kF64}}};
  const auto* const found = std::find_if(
      kTypes.begin(), kTypes.end(), [&](const auto& entry) { return entry.first == f.datatype; });
  if (found == kTypes.end())
    fail(
        "{}: NIfTI datatype {} is not read (colors, complex numbers and 64-bit integers are not); "
        "2, 4, 8, 16, 64, 256, 512 and 768 are",
        path, f.datatype);
  const size_t bits = 8 * bytesPerVoxel(found->second);
  if (f.bitpix != 0 && f.bitpix != static_cast<int64_t>(bits))
    fail("{}: datatype {} ({}) has {} bits per voxel, but bitpix is {}", path, f.datatype,
         name(found->second), bits, f.bitpix);
  return found->second;
}

void readDims(const NiftiFields& f, const std::string& path, VolumeLayout& layout) {
  const int64_t count = f.dim[0];
  if (count < 1 || count > 7) fail("{}: dim[0] is {}, 1 to 7 dimensions expected", path, count);
  std::array<int64_t, 8> dim;
  dim.fill(1);
  for (size_t i = 1; i <= static_cast<size_t>(count); ++i) {
    dim[i] = f.dim[i];
    if (dim[i] < 1) fail("{}: dim[{}] is {}, it must be 1 or more", path, i, dim[i]);
    // Dimension 5 holds several values a voxel; 6 and 7 have no fixed meaning (NIfTI-1,
    // DIMENSIONS).
    if (i > 4 && dim[i] > 1)
      fail("{}: dim[{}] is {}; only volumes of one value per voxel and time step are read", path, i,
           dim[i]);
  }
  layout.dims = {dim[1], dim[2], dim[3]};
  layout.time_steps = dim[4];
}

double voxelSize(const NiftiFields& f, size_t axis) {
  const double size = std::abs(f.pixdim[axis + 1]);
  return size == 0 ? 1 : size;
}

// The rotation of a unit quaternion, of which the file stores all but the first part.
std::array<Vec3d, 3> rotationColumns(const NiftiFields& f, const std::string& path) {
  double b = f.quatern[0], c = f.quatern[1], d = f.quatern[2];
  const double squares = b * b + c * c + d * d;
  // Rounding may bring them a little past 1, which then is a half turn.
  if (!(squares <= 1.01))
    fail("{}: qform's quaternion ({}, {}, {}) is longer than 1", path, b, c, d);
  const double a = std::sqrt(std::max(0.0, 1 - squares));
  const double size = std::sqrt(a * a + squares);
  const double w = a / size;
  b /= size;
  c /= size;
  d /= size;
  return {{{w * w + b * b - c * c - d * d, 2 * (b * c + w * d), 2 * (b * d - w * c)},
           {2 * (b * c - w * d), w * w + c * c - b * b - d * d, 2 * (c * d + w * b)},
           {2 * (b * d + w * c), 2 * (c * d - w * b), w * w + d * d - b * b - c * c}}};
}

// Names each field whose value has no meaning in the standard, and the value that is used instead.
// A slope that is not a number is none of them: nibabel writes it for unscaled values.
void noteSlips(const NiftiFields& f, const std::string& path, VolumeLayout& layout) {
  const auto note = [&](std::string_view field, const auto& value, std::string_view used) {
    layout.notes.push_back(fmt::format("{}: {} is {}; {}", path, field, value, used));
  };
  for (const auto& [field, code] :
       {std::pair("qform_code", f.qform_code), std::pair("sform_code", f.sform_code)})
    if (code < 0 || code > 5)
      note(field, code, code > 0 ? "it is used as 1" : "from 0 to 5 expected, it is used as 0");
  if (f.xyzt_units < 0 || f.xyzt_units > 63 || (f.xyzt_units & 7) > 3)
    note("xyzt_units", f.xyzt_units, "it names no unit of length");
  if (f.sform_code > 0) return;
  if (f.qform_code > 0 && std::abs(f.pixdim[0]) != 1 && f.pixdim[0] != 0)
    note("pixdim[0]", f.pixdim[0], "only its sign is used");
  for (int axis = 0; axis < 3; ++axis) {
    const double size = f.pixdim[static_cast<size_t>(axis) + 1];
    const std::string field = fmt::format("pixdim[{}]", axis + 1);
    if (size < 0) note(field, size, "only its magnitude is used");
    if (size == 0 && layout.dims[axis] > 1) note(field, size, "a voxel size of 1 is used");
  }
}

void readGeometry(const NiftiFields& f, const std::string& path, VolumeLayout& layout) {
  std::vector<Vec3d> steps(3);
  Vec3d origin;
  // Method 3 (sform) before method 2 (qform): the standard leaves the choice, and nibabel and ITK
  // take the sform first.
  if (f.sform_code > 0) {
    for (size_t axis = 0; axis < 3; ++axis)
      steps[axis] = {f.srow[0][axis], f.srow[1][axis], f.srow[2][axis]};
    origin = {f.srow[0][3], f.srow[1][3], f.srow[2][3]};
  } else if (f.qform_code > 0) {
    const std::array<Vec3d, 3> columns = rotationColumns(f, path);
    // pixdim[0] is qfac: a left-handed image has -1, and 0 counts as 1 (NIfTI-1, METHOD 2).
    const double handedness = f.pixdim[0] < 0 ? -1 : 1;
    for (size_t axis = 0; axis < 3; ++axis)
      steps[axis] = columns[axis] * (voxelSize(f, axis) * (axis == 2 ? handedness : 1));
    origin = {f.qoffset[0], f.qoffset[1], f.qoffset[2]};
  } else {
    for (size_t axis = 0; axis < 3; ++axis)
      steps[axis][static_cast<int>(axis)] = voxelSize(f, axis);
  }
  setSteps(path, steps, layout);
  setOrigin(path, origin, layout);
  constexpr std::array<const char*, 8> kUnits = {"", "meter", "millimeter", "micrometer"};
  const bool is_unit = f.xyzt_units >= 0 && f.xyzt_units <= 63;
  const char* unit = kUnits[is_unit ? static_cast<size_t>(f.xyzt_units & 7) : 0];
  layout.unit = unit == nullptr ? "" : unit;
  layout.frame = WorldFrame::kRas;
  if (f.sform_code <= 0 && f.qform_code <= 0)
    layout.notes.push_back(
        fmt::format("{}: the header has no orientation (no qform, no sform); sluice assumes that x "
                    "grows to the right, y to the front, z upwards",
                    path));
}

// Programs that do not know the time between steps write 0. Frequencies are axes of other kinds.
std::optional<TimeAxis> readTimes(const NiftiFields& f, const std::string& path,
                                  VolumeLayout& layout) {
  constexpr std::array<const char*, 4> kUnits = {"", "second", "millisecond", "microsecond"};
  const auto unit = static_cast<uint64_t>(f.xyzt_units) >> 3;
  if (layout.time_steps < 2 || unit >= kUnits.size() || f.pixdim[4] == 0) return std::nullopt;
  TimeAxis times{f.pixdim[4], f.toffset, kUnits[unit]};
  const auto note = [&](const char* field, double said, const char* what, double used) {
    layout.notes.push_back(fmt::format("{}: {} is {}; a {} of {:g}{} is used", path, field, said,
                                       what, used, times.unit.empty() ? "" : " " + times.unit));
    return used;
  };
  if (!std::isfinite(times.step) || times.step < 0)
    times.step = note("pixdim[4]", times.step, "time between steps", 1);
  if (!std::isfinite(times.start))
    times.start = note("toffset", times.start, "time of the first step", 0);
  return times;
}

int64_t voxelOffset(const NiftiFields& f, bool pair, const std::string& path) {
  const size_t least = pair ? 0 : f.header_bytes + kExtensionFlagBytes;
  // 2^53: beyond it a double skips whole numbers.
  if (!(f.vox_offset >= static_cast<double>(least) && f.vox_offset <= 0x1p53) ||
      f.vox_offset != std::floor(f.vox_offset))
    fail("{}: vox_offset is {}, a whole number from {} on expected", path, f.vox_offset, least);
  return static_cast<int64_t>(f.vox_offset);
}

}  // namespace

NiftiHeader parseNiftiHeader(std::span<const std::byte> bytes, const std::string& path) {
  if (bytes.size() < kNifti1Bytes)
    fail("{}: no NIfTI file: {} bytes, the header alone has {}", path, bytes.size(), kNifti1Bytes);
  bool swapped = false;
  // The header's own size tells the byte order and the version.
  for (const bool candidate : {false, true}) {
    const int32_t size = firstNumber(bytes, candidate);
    if (size == static_cast<int32_t>(kNifti1Bytes) ||
        size == static_cast<int32_t>(kNiftiHeaderBytes))
      swapped = candidate;
  }
  const int32_t header_bytes = firstNumber(bytes, swapped);
  const bool second = header_bytes == static_cast<int32_t>(kNiftiHeaderBytes);
  if (!second && header_bytes != static_cast<int32_t>(kNifti1Bytes))
    fail("{}: no NIfTI file: sizeof_hdr is {}, {} or {} expected", path, header_bytes, kNifti1Bytes,
         kNiftiHeaderBytes);
  if (second && bytes.size() < kNiftiHeaderBytes)
    fail("{}: {} bytes, the NIfTI-2 header alone has {}", path, bytes.size(), kNiftiHeaderBytes);
  const NiftiFields fields = readFields(Reader(bytes, swapped), second);

  NiftiHeader header;
  const std::string_view single =
      second ? std::string_view("n+2\0\r\n\032\n", 8) : std::string_view("n+1\0", 4);
  const std::string_view pair =
      second ? std::string_view("ni2\0\r\n\032\n", 8) : std::string_view("ni1\0", 4);
  header.pair = fields.magic == pair;
  if (!header.pair && fields.magic != single)
    fail(
        "{}: no NIfTI file: it has the header of one but not its magic (ANALYZE files are not "
        "read)",
        path);
  VolumeDescription& description = header.description;
  VolumeLayout& layout = description.layout;
  description.byte_order = swapped == (std::endian::native == std::endian::little)
                               ? std::endian::big
                               : std::endian::little;
  layout.type = voxelType(fields, path);
  readDims(fields, path, layout);
  checkedVolumeBytes(path, layout);
  readGeometry(fields, path, layout);
  header.times = readTimes(fields, path, layout);
  noteSlips(fields, path, layout);
  // A slope of 0 means that values are not scaled (NIfTI-1, DATA SCALING).
  if (!std::isnan(fields.scl_slope) && fields.scl_slope != 0)
    setValueScale(path, fields.scl_slope, fields.scl_inter, layout);
  description.byte_skip = voxelOffset(fields, header.pair, path);
  return header;
}

}  // namespace sluice

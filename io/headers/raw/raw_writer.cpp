#include "io/headers/raw/raw_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>

#include "io/files/file_list.h"
#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/file_kind.h"
#include "src/base/files/numbered_name.h"

namespace sluice {
namespace {

// "uint8", "int16", "float32".
std::string longName(VoxelType type) {
  const std::string_view brief = name(type);
  const char* stem = brief[0] == 'u' ? "uint" : brief[0] == 'i' ? "int" : "float";
  return fmt::format("{}{}", stem, brief.substr(1));
}

std::string metaImageType(VoxelType type) {
  constexpr const char* kNames[] = {"MET_UCHAR", "MET_CHAR", "MET_USHORT", "MET_SHORT",
                                    "MET_UINT",  "MET_INT",  "MET_FLOAT",  "MET_DOUBLE"};
  return kNames[static_cast<size_t>(type)];
}

std::string nrrdType(VoxelType type) {
  if (type == VoxelType::kF32) return "float";
  if (type == VoxelType::kF64) return "double";
  return longName(type);
}

constexpr bool kLittle = std::endian::native == std::endian::little;

// `data_file` is empty for an attached header, which then ends with the blank line.
std::string nrrdHeader(const VolumeLayout& layout, const std::string& data_file) {
  std::string header = fmt::format("NRRD0004\n# {}\n", softwareMark());
  header += fmt::format("type: {}\ndimension: 3\nsizes: {} {} {}\n", nrrdType(layout.type),
                        layout.dims.x, layout.dims.y, layout.dims.z);
  const std::string_view space = layout.frame == WorldFrame::kRas ? "space: right-anterior-superior"
                                 : layout.frame == WorldFrame::kLps
                                     ? "space: left-posterior-superior"
                                     : "space dimension: 3";
  header += fmt::format(
      "endian: {}\nencoding: raw\n{}\nspace directions:", kLittle ? "little" : "big", space);
  for (int a = 0; a < 3; ++a) {
    const Vec3d edge = layout.axes[static_cast<size_t>(a)] * layout.spacing[a];
    header += fmt::format(" ({},{},{})", edge.x, edge.y, edge.z);
  }
  header += fmt::format("\nspace origin: ({},{},{})\n", layout.origin.x, layout.origin.y,
                        layout.origin.z);
  header += data_file.empty() ? "\n" : fmt::format("data file: {}\n", data_file);
  return header;
}

std::string metaImageHeader(const VolumeLayout& layout, const std::string& data_file) {
  std::string matrix;
  for (const Vec3d& axis : layout.axes) matrix += fmt::format(" {} {} {}", axis.x, axis.y, axis.z);
  return fmt::format(
      "ObjectType = Image\nComment = {}\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = "
      "{}\n"
      "CompressedData = False\nAnatomicalOrientation = {}\nTransformMatrix ={}\nOffset = {} {} {}\n"
      "ElementSpacing = {} {} {}\nDimSize = {} {} {}\nElementType = {}\nElementDataFile = {}\n",
      softwareMark(), kLittle ? "False" : "True", layout.frame == WorldFrame::kLps ? "RAI" : "???",
      matrix, layout.origin.x, layout.origin.y, layout.origin.z, layout.spacing.x, layout.spacing.y,
      layout.spacing.z, layout.dims.x, layout.dims.y, layout.dims.z, metaImageType(layout.type),
      data_file);
}

// Cuts a box into pieces of at most `most_voxels` in the file's order, each contiguous there:
// whole planes, or rows of one plane, or a part of one row. Requires: the box is itself whole
// planes, or rows of one plane, or a part of one row.
void eachPiece(const Box3& box, int64_t most_voxels,
               const std::function<void(const Box3&)>& piece) {
  const Vec3i size = box.size();
  const std::array<int64_t, 3> step_voxels = {1, size.x, size.x * size.y};  // along x, y, z
  int axis = 2;
  while (axis > 0 && step_voxels[static_cast<size_t>(axis)] > most_voxels && size[axis] == 1)
    --axis;
  const int64_t unit = step_voxels[static_cast<size_t>(axis)];
  const int64_t steps = std::max<int64_t>(1, most_voxels / unit);
  for (int64_t i = box.lo[axis]; i < box.hi[axis]; i += steps) {
    Box3 part = box;
    part.lo[axis] = i;
    part.hi[axis] = std::min(i + steps, box.hi[axis]);
    if (unit > most_voxels && axis > 0)
      eachPiece(part, most_voxels, piece);
    else
      piece(part);
  }
}

bool allZero(std::span<const std::byte> bytes) {
  return bytes.empty() || (bytes[0] == std::byte{0} &&
                           std::memcmp(bytes.data(), bytes.data() + 1, bytes.size() - 1) == 0);
}

// The voxels' way into the temporary file of an AtomicFile, skipping zeros.
class HoleyFile {
 public:
  HoleyFile(const AtomicFile& file, uint64_t offset, bool holes)
      : path_(file.temporaryPath().string()),
        offset_(offset),
        holes_(holes),
        file_(open(path_.c_str(), O_WRONLY | O_CLOEXEC)) {
    if (!file_) failErrno(fmt::format("{}: cannot be written", path_), errno);
  }

  void skip(uint64_t bytes) { offset_ += bytes; }

  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      // Bytes up to the next multiple of the unit in the file: file systems free whole blocks only.
      const size_t to_unit = kUnit - offset_ % kUnit;
      const auto part = bytes.first(std::min(bytes.size(), to_unit));
      if (!holes_ || !allZero(part))
        writeAllAt(file_.get(), part, offset_, fmt::format("{}: write failed", path_));
      offset_ += part.size();
      bytes = bytes.subspan(part.size());
    }
  }

  // Gives the file its length, a hole at its end included.
  void finish() {
    if (ftruncate(file_.get(), static_cast<off_t>(offset_)) != 0)
      failErrno(fmt::format("{}: write failed", path_), errno);
  }

 private:
  static constexpr size_t kUnit = 64 << 10;

  const std::string path_;
  uint64_t offset_;
  const bool holes_;
  const Descriptor file_;
};

class StepWriter {
 public:
  StepWriter(VolumeSource& source, const VolumeWriteOptions& options, WorkerPool& pool,
             ProgressMeter& progress)
      : source_(source), options_(options), pool_(pool), progress_(progress) {
    const auto voxel_bytes = static_cast<int64_t>(bytesPerVoxel(source.layout().type));
    most_voxels_ = std::max<int64_t>(1, static_cast<int64_t>(options.buffer_bytes) / voxel_bytes);
    voxel_bytes_ = voxel_bytes;
  }

  // Header (may be empty) and voxels of one step.
  void write(int64_t time, const std::filesystem::path& path, const std::string& header) {
    AtomicFile file(path);
    file.write(header);
    HoleyFile voxels(file, header.size(), options_.holes);
    const std::optional<Occupancy> occupancy = source_.occupancy(time);
    eachPiece(boxOf(source_.layout().dims), most_voxels_, [&](const Box3& slab) {
      options_.stop.throwIfStopped();
      const auto bytes = static_cast<uint64_t>(slab.count() * voxel_bytes_);
      if (options_.holes && occupancy && knownZero(*occupancy, slab)) {
        voxels.skip(bytes);
      } else {
        read(time, slab);
        voxels.write(std::span(buffer_).first(bytes));
      }
      progress_.add(bytes);
    });
    voxels.finish();
    file.commit();
  }

 private:
  static bool knownZero(const Occupancy& occupancy, const Box3& box) {
    return occupancy.background == 0 &&
           std::none_of(occupancy.boxes.begin(), occupancy.boxes.end(),
                        [&](const Box3& other) { return !intersect(box, other).empty(); });
  }

  // Fills the buffer with the slab, all threads at work on pieces of it.
  void read(int64_t time, const Box3& slab) {
    buffer_.resize(std::max(buffer_.size(), static_cast<size_t>(slab.count() * voxel_bytes_)));
    std::vector<std::pair<Box3, int64_t>> pieces;  // with the first voxel's place in the slab
    int64_t first = 0;
    eachPiece(slab, kPieceVoxels, [&](const Box3& piece) {
      pieces.emplace_back(piece, first);
      first += piece.count();
    });
    pool_.parallelFor(static_cast<int64_t>(pieces.size()), [&](int64_t i) {
      const auto& [piece, at] = pieces[static_cast<size_t>(i)];
      source_.readRegion(
          time, piece,
          std::span(buffer_).subspan(static_cast<size_t>(at * voxel_bytes_),
                                     static_cast<size_t>(piece.count() * voxel_bytes_)));
    });
  }

  static constexpr int64_t kPieceVoxels = 1 << 20;
  VolumeSource& source_;
  const VolumeWriteOptions& options_;
  WorkerPool& pool_;
  ProgressMeter& progress_;
  int64_t most_voxels_ = 1, voxel_bytes_ = 1;
  std::vector<std::byte> buffer_;
};

std::filesystem::path nameOfStep(const std::filesystem::path& path, const VolumeLayout& layout,
                                 int64_t step) {
  return numberedName(path.string(), step, layout.time_steps > 1);
}

// The file for the voxels of a header.
std::filesystem::path dataFileOf(const std::filesystem::path& header) {
  return std::filesystem::path(header).replace_extension(".raw");
}

// ".raw", ".nrrd", ".nhdr" or ".mhd".
std::string formatOf(const std::filesystem::path& path) {
  std::string extension = lowerExtension(path);
  if (extension != ".raw" && extension != ".nrrd" && extension != ".nhdr" && extension != ".mhd")
    fail("{}: expected a name ending in .raw, .nrrd, .nhdr or .mhd to write a volume to",
         path.string());
  return extension;
}

}  // namespace

std::vector<std::filesystem::path> filesToWrite(const VolumeLayout& layout,
                                                const std::filesystem::path& path) {
  const std::string format = formatOf(path);
  std::vector<std::filesystem::path> files;
  for (int64_t step = 0; step < layout.time_steps; ++step) {
    files.push_back(nameOfStep(path, layout, step));
    if (format == ".nhdr" || format == ".mhd") files.push_back(dataFileOf(files.back()));
  }
  return files;
}

std::vector<std::filesystem::path> writeVolume(VolumeSource& source,
                                               const std::filesystem::path& path,
                                               const VolumeWriteOptions& options, WorkerPool& pool,
                                               ProgressMeter& progress) {
  const VolumeLayout& layout = source.layout();
  const std::string extension = formatOf(path);
  StepWriter writer(source, options, pool, progress);
  std::vector<std::filesystem::path> made;
  for (int64_t step = 0; step < layout.time_steps; ++step) {
    const std::filesystem::path step_path = nameOfStep(path, layout, step);
    if (extension == ".raw") {
      made.push_back(step_path);
      writer.write(step, made.back(), "");
    } else if (extension == ".nrrd") {
      made.push_back(step_path);
      writer.write(step, step_path, nrrdHeader(layout, ""));
    } else {
      const std::filesystem::path data = dataFileOf(step_path);
      const std::string data_name = data.filename().string();
      // The header first, so that no voxels stay without one if the disk is full.
      AtomicFile header(step_path);
      header.write(extension == ".nhdr" ? nrrdHeader(layout, data_name)
                                        : metaImageHeader(layout, data_name));
      writer.write(step, data, "");
      header.commit();
      made.push_back(step_path);
      made.push_back(data);
    }
  }
  return made;
}

}  // namespace sluice

#include "io/headers/raw/raw.h"

#include <string>

#include "io/files/file_list.h"
#include "io/headers/described_volume.h"
#include "io/headers/raw/raw_name.h"
#include "io/headers/raw/raw_source.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr const char* kExampleName = "head_256x256x225_uint8.raw";

// The end of a message about a volume over another one.
std::string nameAdvice() {
  return fmt::format(
      "--dims, --type and --skip describe the first volume; put size and type into the name of "
      "this one, such as {}, or give it a header",
      kExampleName);
}

// "u8 or i8", for the type that --type should name.
std::string typesOfSize(uint64_t voxel_bytes) {
  std::string names;
  for (int i = 0; i <= static_cast<int>(VoxelType::kF64); ++i) {
    const auto type = static_cast<VoxelType>(i);
    if (bytesPerVoxel(type) == voxel_bytes)
      names += (names.empty() ? "" : " or ") + std::string(name(type));
  }
  return names;
}

[[noreturn]] void failTypeMissing(const File& file, VolumeLayout layout, const RawOptions& options,
                                  bool size_known) {
  if (options.is_over) failRequest("{}: voxel type unknown; {}", file.path(), nameAdvice());
  layout.type = VoxelType::kU8;
  const uint64_t voxels = static_cast<uint64_t>(checkedVolumeBytes(file.path(), layout));
  const uint64_t skip = static_cast<uint64_t>(options.skip_bytes);
  const uint64_t bytes = file.sizeBytes() - std::min(file.sizeBytes(), skip);
  const std::string fitting = size_known && bytes % voxels == 0 ? typesOfSize(bytes / voxels) : "";
  if (!size_known) failRequest("{}: voxel type unknown; give --type", file.path());
  failRequest(
      "{}: voxel type unknown; {} bytes / ({} x {} x {} x {} steps) = {:g} bytes a voxel: {}",
      file.path(), bytes, layout.dims.x, layout.dims.y, layout.dims.z, layout.time_steps,
      static_cast<double>(bytes) / static_cast<double>(voxels),
      fitting.empty() ? "no type fits, --dims or --skip is wrong" : "give --type " + fitting);
}

void demandExactSize(const File& file, const VolumeDescription& description,
                     const RawOptions& options) {
  const VolumeLayout& layout = description.layout;
  const uint64_t voxels_bytes = static_cast<uint64_t>(checkedVolumeBytes(file.path(), layout));
  const uint64_t skip = static_cast<uint64_t>(description.byte_skip);
  const uint64_t size = file.sizeBytes();
  // Exactly: dimensions that are wrong would show a sheared volume, and no error.
  if (size == voxels_bytes + skip) return;
  const uint64_t rest = size - std::min(size, skip);
  std::string advice = options.is_over ? nameAdvice() : "give --dims, --type or --skip";
  if (!options.is_over && layout.time_steps == 1 && rest > voxels_bytes && rest % voxels_bytes == 0)
    advice = fmt::format("these are {} time steps: give --dims {},{},{},{}", rest / voxels_bytes,
                         layout.dims.x, layout.dims.y, layout.dims.z, rest / voxels_bytes);
  failRequest("{}: {} expected, {} found; {}", file.path(),
              sizeArithmetic(layout, description.byte_skip), size, advice);
}

void setByteOrderAndSpacing(const std::string& path, const RawOptions& options,
                            const RawName& from_name, VolumeDescription& description) {
  description.byte_order =
      options.byte_order.value_or(from_name.byte_order.value_or(std::endian::little));
  const Vec3d spacing = options.spacing.value_or(Vec3d{1, 1, 1});
  if (!(spacing.x > 0 && spacing.y > 0 && spacing.z > 0))
    failRequest("{}: --spacing {},{},{} must be above 0", path, spacing.x, spacing.y, spacing.z);
  setSteps(path, {{spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, spacing.z}}, description.layout);
}

void setSkip(const std::string& path, const RawOptions& options, VolumeDescription& description) {
  if (options.skip_bytes < 0 || options.skip_bytes > kMostSkipBytes)
    failRequest("{}: --skip {} is not from 0 to {}", path, options.skip_bytes, kMostSkipBytes);
  description.byte_skip = options.skip_bytes;
}

std::string selectionOf(const VolumeDescription& description) {
  const VolumeLayout& layout = description.layout;
  return fmt::format("{}x{}x{}x{} {} {} skip {}", layout.dims.x, layout.dims.y, layout.dims.z,
                     layout.time_steps, name(layout.type),
                     description.byte_order == std::endian::little ? "le" : "be",
                     description.byte_skip);
}

VolumeDescription describe(const File& file, const RawOptions& options, bool compressed) {
  const std::string file_name = std::filesystem::path(file.path()).filename().string();
  const RawName from_name = parseRawName(file_name);
  VolumeDescription description;
  VolumeLayout& layout = description.layout;
  const std::optional<Vec3i> dims = options.dims ? options.dims : from_name.dims;
  if (!dims && options.is_over)
    failRequest("{}: dimensions unknown; {}", file.path(), nameAdvice());
  if (!dims)
    failRequest("{}: dimensions unknown; give --dims X,Y,Z or put them into the name, such as {}",
                file.path(), kExampleName);
  layout.dims = *dims;
  // Dimensions that the user gave replace all four of the name.
  layout.time_steps = (options.dims ? options.time_steps : from_name.time_steps).value_or(1);
  setSkip(file.path(), options, description);
  const std::optional<VoxelType> type = options.type ? options.type : from_name.type;
  if (!type) failTypeMissing(file, layout, options, !compressed);
  layout.type = *type;
  setByteOrderAndSpacing(file.path(), options, from_name, description);
  return description;
}

}  // namespace

std::unique_ptr<VolumeSource> openRaw(const std::filesystem::path& path,
                                      const RawOptions& options) {
  auto file = std::make_shared<File>(path);
  const bool compressed = path.extension() == ".gz";
  VolumeDescription description = describe(*file, options, compressed);
  if (compressed)
    description.encoding = Encoding::kDeflate;
  else
    demandExactSize(*file, description, options);
  return openDescribed(std::move(file), description, selectionOf(description), options.decode);
}

std::unique_ptr<VolumeSource> openRawSlices(const std::vector<std::filesystem::path>& files,
                                            const RawOptions& options) {
  SLUICE_CHECK(!files.empty());
  const std::string first = files[0].string();
  if (!options.dims || !options.type)
    failRequest("{}: raw slices need --dims X,Y,{} and --type T", first, files.size());
  VolumeDescription description;
  VolumeLayout& layout = description.layout;
  layout.dims = *options.dims;
  layout.type = *options.type;
  if (options.time_steps.value_or(1) != 1 || layout.dims.z != static_cast<int64_t>(files.size()))
    failRequest("{}: {} raw slices, but --dims is {} x {} x {} x {} steps; give --dims {},{},{}",
                first, files.size(), layout.dims.x, layout.dims.y, layout.dims.z,
                options.time_steps.value_or(1), layout.dims.x, layout.dims.y, files.size());
  setSkip(first, options, description);
  setByteOrderAndSpacing(first, options, {}, description);
  const auto slice_bytes = static_cast<uint64_t>(checkedVolumeBytes(first, layout) / layout.dims.z);
  const auto skip = static_cast<uint64_t>(description.byte_skip);
  constexpr size_t kMostFilesOpen = 64;
  const File::Keep keep = files.size() > kMostFilesOpen ? File::Keep::kClosed : File::Keep::kOpen;
  std::vector<RawSegment> segments;
  for (const std::filesystem::path& path : files) {
    auto file = std::make_shared<File>(path, keep);
    if (file->sizeBytes() != slice_bytes + skip)
      failRequest(
          "{}: {} x {} x {} bytes ({}) + {} skipped = {} bytes of a slice expected, {} found",
          path.string(), layout.dims.x, layout.dims.y, bytesPerVoxel(layout.type),
          name(layout.type), skip, slice_bytes + skip, file->sizeBytes());
    segments.push_back({std::move(file), skip});
  }
  layout.name = files[0].filename().string();
  layout.path = first;
  layout.frame = WorldFrame::kPictureRows;
  if (const auto gap = gapNote(files)) layout.notes.push_back(*gap);
  const std::string identity = fileIdentity(files) + "|" + selectionOf(description);
  return std::make_unique<RawSource>(layout, description.byte_order, std::move(segments), nullptr,
                                     identity);
}

}  // namespace sluice

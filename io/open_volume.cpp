#include "io/open_volume.h"

#include <array>
#include <filesystem>
#include <map>
#include <string_view>
#include <utility>

#include "io/files/file.h"
#include "io/files/file_list.h"
#include "io/headers/meta_image.h"
#include "io/headers/nifti.h"
#include "io/headers/nrrd.h"
#include "io/headers/raw.h"
#include "io/headers/raw_name.h"
#include "io/sequence.h"
#include "io/slices/slice_picture.h"
#include "io/slices/slice_stack.h"
#include "io/stores/folder_store.h"
#include "io/synth/synth_source.h"
#include "io/vdb/vdb_series.h"
#include "io/vdb/vdb_source.h"
#include "io/web/address.h"
#include "io/web/web_place.h"
#include "io/zarr/zarr_folder.h"
#include "io/zarr/zarr_source.h"
#include "src/base/error.h"
#include "src/base/values/forwarding_source.h"

namespace sluice {
namespace {

using namespace std::string_view_literals;
namespace fs = std::filesystem;

enum class Format { kNrrd, kMetaImage, kNifti, kVdb, kPicture, kRaw, kZarr, kUnknown };

constexpr std::string_view kUnderstood =
    "NRRD, MetaImage, NIfTI, OpenVDB, Zarr, PNG or TIFF slices, or raw with --dims X,Y,Z --type T";

Format formatOfContent(const fs::path& path) {
  std::array<std::byte, 4096> bytes{};
  File file(path);
  const size_t got = file.readSome(0, bytes);
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), got);
  const auto has = [&](size_t at, std::string_view magic) {
    return head.size() >= at + magic.size() && head.substr(at, magic.size()) == magic;
  };
  if (has(0, "NRRD")) return Format::kNrrd;
  if (has(0, " BDV")) return Format::kVdb;
  if (isSlicePicture(path)) return Format::kPicture;
  constexpr size_t kNifti1MagicAt = 344, kNifti2MagicAt = 4;
  if (has(kNifti1MagicAt, "n+1\0"sv) || has(kNifti1MagicAt, "ni1\0"sv) ||
      has(kNifti2MagicAt, "n+2\0"sv) || has(kNifti2MagicAt, "ni2\0"sv))
    return Format::kNifti;
  const std::string_view first_line = head.substr(0, head.find('\n'));
  const bool starts_as_meta = first_line.find('=') != std::string_view::npos &&
                              first_line.find('\0') == std::string_view::npos;
  if (starts_as_meta && head.find("DimSize") != std::string_view::npos) return Format::kMetaImage;
  return Format::kUnknown;
}

Format formatOfName(const fs::path& path, const OpenOptions& options) {
  const std::string extension = lowerExtension(path);
  if (extension == ".nrrd" || extension == ".nhdr") return Format::kNrrd;
  if (extension == ".mhd" || extension == ".mha") return Format::kMetaImage;
  if (extension == ".nii" || extension == ".nii.gz" || extension == ".hdr" ||
      extension == ".hdr.gz")
    return Format::kNifti;
  if (extension == ".img" || extension == ".img.gz") {
    fs::path header = path;
    if (extension == ".img.gz") header.replace_extension();
    header.replace_extension(".hdr");
    for (const auto* const end : {"", ".gz"}) {
      if (fs::exists(header.string() + end)) return Format::kNifti;
    }
    return Format::kRaw;
  }
  if (extension == ".vdb") return Format::kVdb;
  if (extension == ".png" || extension == ".tif" || extension == ".tiff") return Format::kPicture;
  if (extension == ".raw" || extension == ".raw.gz" || options.dims || options.type ||
      parseRawName(path.filename().string()).dims)
    return Format::kRaw;
  return Format::kUnknown;
}

// A source with some properties replaced: the distances between its voxels, notes.
class RelabelledSource final : public ForwardingSource {
 public:
  RelabelledSource(std::unique_ptr<VolumeSource> source, VolumeLayout layout)
      : ForwardingSource(std::move(source)), layout_(std::move(layout)) {}
  const VolumeLayout& layout() const override { return layout_; }

 private:
  const VolumeLayout layout_;
};

std::unique_ptr<VolumeSource> respaced(std::unique_ptr<VolumeSource> source,
                                       const OpenOptions& options) {
  if (!options.spacing) return source;
  VolumeLayout layout = source->layout();
  layout.spacing = *options.spacing;
  return std::make_unique<RelabelledSource>(std::move(source), std::move(layout));
}

std::unique_ptr<VolumeSource> withNote(std::unique_ptr<VolumeSource> source,
                                       const std::optional<std::string>& note) {
  if (!note) return source;
  VolumeLayout layout = source->layout();
  layout.notes.push_back(*note);
  return std::make_unique<RelabelledSource>(std::move(source), std::move(layout));
}

void checkOptions(const std::string& input, Format format, const OpenOptions& options) {
  const bool is_described = options.dims || options.time_steps || options.type ||
                            options.byte_order || options.skip_bytes != 0;
  if (format != Format::kRaw && is_described)
    fail(
        "{}: the file contains its size and type; leave out --dims, --type, --endian and --skip, "
        "which are for raw files",
        input);
  if (format != Format::kVdb && !options.grid.empty())
    fail("{}: --grid {} is for OpenVDB files, which this is not; leave it out", input,
         options.grid);
  if (format != Format::kZarr && format != Format::kPicture && options.channel.given())
    fail("{}: --channel {} is for Zarr stores and TIFF files, which this is not; leave it out",
         input, options.channel.text());
  if (options.spacing) {
    const Vec3d s = *options.spacing;
    for (int a = 0; a < 3; ++a) {
      if (!(s[a] > 0) || !std::isfinite(s[a]))
        fail("{}: spacing {}, {}, {}, expected three positive numbers", input, s.x, s.y, s.z);
    }
  }
}

DecodeOptions decodeOptionsOf(const OpenOptions& options) {
  DecodeOptions decode = options.decode;
  decode.stop = options.stop;
  return decode;
}

RawOptions rawOptions(const OpenOptions& options) {
  return {.dims = options.dims,
          .time_steps = options.time_steps,
          .type = options.type,
          .byte_order = options.byte_order,
          .skip_bytes = options.skip_bytes,
          .spacing = options.spacing,
          .decode = decodeOptionsOf(options)};
}

SliceOptions sliceOptions(const OpenOptions& options) {
  return {.spacing = options.spacing, .channel = options.channel, .stop = options.stop};
}

std::unique_ptr<VolumeSource> openFolder(const fs::path& folder, const OpenOptions& options) {
  if (options.dims && options.type) {  // needed for slices without headers
    checkOptions(folder.string(), Format::kRaw, options);
    return openRawSlices(listFolder(folder), rawOptions(options));
  }
  checkOptions(folder.string(), Format::kPicture, options);
  return openSliceFolder(folder, sliceOptions(options));
}

ZarrOptions zarrOptions(const OpenOptions& options) {
  return {.channel = options.channel, .chunk_cache_bytes = options.chunk_cache_bytes};
}

std::unique_ptr<VolumeSource> openAddress(const std::string& input, const OpenOptions& options) {
  const StorePlace place = webPlace(input, options.buckets, options.stop);
  checkOptions(place.name(), Format::kZarr, options);
  if (!isZarr(place))
    fail(
        "{}: expected a Zarr store, found neither zarr.json nor .zarray nor .zgroup there; "
        "download files of other kinds first",
        place.name());
  return respaced(std::make_unique<ZarrSource>(place, zarrOptions(options)), options);
}

// A name that stands for one source: a file, a folder, an address, a synthetic volume.
std::unique_ptr<VolumeSource> openOne(const std::string& input, const OpenOptions& options) {
  const fs::path path(input);
  if (isSynthSpec(input)) {
    checkOptions(input, Format::kUnknown, options);
    return respaced(openSynth(parseSynthSpec(input)), options);
  }
  if (isAddress(input)) return openAddress(input, options);
  if (fs::is_directory(path) && isZarr(folderPlace(path))) {
    checkOptions(input, Format::kZarr, options);
    return respaced(std::make_unique<ZarrSource>(path, zarrOptions(options)), options);
  }
  if (fs::is_directory(path)) return openFolder(path, options);
  Format format = formatOfContent(path);
  if (format == Format::kUnknown) format = formatOfName(path, options);
  if (format == Format::kUnknown) fail("{}: unknown kind of file, expected {}", input, kUnderstood);
  checkOptions(input, format, options);
  switch (format) {
    case Format::kNrrd:
      return respaced(openNrrd(path, decodeOptionsOf(options)), options);
    case Format::kMetaImage:
      return respaced(openMetaImage(path, decodeOptionsOf(options)), options);
    case Format::kNifti:
      return respaced(openNifti(path, decodeOptionsOf(options)), options);
    case Format::kVdb:
      return respaced(openVdb(path, options.grid), options);
    case Format::kPicture:
      return openSlices({path}, sliceOptions(options));
    case Format::kRaw:
    case Format::kZarr:
    case Format::kUnknown:
      break;
  }
  return openRaw(path, rawOptions(options));
}

// The box to deliver of each step if all steps of a series are OpenVDB files; empty otherwise.
std::map<std::string, Box3> boxesOfVdbSteps(const std::vector<std::string>& files,
                                            const OpenOptions& options) {
  for (const std::string& file : files)
    if (isSynthSpec(file) || isAddress(file) || fs::is_directory(file) ||
        formatOfContent(file) != Format::kVdb)
      return {};
  checkOptions(files[0], Format::kVdb, options);
  const std::vector<Box3> boxes =
      vdbSeriesBoxes({files.begin(), files.end()}, options.grid, options.stop);
  std::map<std::string, Box3> by_name;
  for (size_t i = 0; i < files.size(); ++i) by_name[files[i]] = boxes[i];
  return by_name;
}

bool isSlice(const std::string& input) {
  if (isSynthSpec(input) || isAddress(input) || fs::is_directory(input) || !isSlicePicture(input))
    return false;
  return openSlicePicture(input)->format().pages == 1;
}

// Whether these are raw files each of which has the bytes of one slice of --dims.
bool areRawSlices(const std::vector<std::string>& files, const OpenOptions& options) {
  if (!options.dims || !options.type || static_cast<size_t>(options.dims->z) != files.size())
    return false;
  std::error_code unknown;
  const auto slice_bytes =
      static_cast<uint64_t>(options.dims->x * options.dims->y) * bytesPerVoxel(*options.type);
  return fs::file_size(files[0], unknown) ==
         slice_bytes + static_cast<uint64_t>(options.skip_bytes);
}

std::unique_ptr<VolumeSource> openSeveral(const std::vector<std::string>& files,
                                          const OpenOptions& options) {
  if (isSlice(files[0])) {
    checkOptions(files[0], Format::kPicture, options);
    return openSlices({files.begin(), files.end()}, sliceOptions(options));
  }
  if (areRawSlices(files, options)) {
    checkOptions(files[0], Format::kRaw, options);
    return openRawSlices({files.begin(), files.end()}, rawOptions(options));
  }
  const std::map<std::string, Box3> boxes = boxesOfVdbSteps(files, options);
  return std::make_unique<SequenceSource>(files, [options, boxes](const std::string& path) {
    const auto box = boxes.find(path);
    return box == boxes.end() ? openOne(path, options)
                              : respaced(openVdb(path, options.grid, box->second), options);
  });
}

}  // namespace

std::unique_ptr<VolumeSource> openVolume(const std::string& input, const OpenOptions& options) {
  return openVolume(std::vector<std::string>{input}, options);
}

std::unique_ptr<VolumeSource> openVolume(const std::vector<std::string>& inputs,
                                         const OpenOptions& options) {
  SLUICE_CHECK(!inputs.empty());
  std::vector<std::string> files;
  for (const std::string& input : inputs) {
    if (isSynthSpec(input) || isAddress(input) || !isPattern(input)) {
      files.push_back(input);
      continue;
    }
    const auto matches = expandPattern(input);
    requireOneSeries(input, matches);
    for (const fs::path& file : matches) files.push_back(file.string());
  }
  if (files.size() == 1) return openOne(files[0], options);
  const std::optional<std::string> note = orderByNumbers(files);
  return withNote(openSeveral(files, options), note);
}

namespace {

// The files of a series with one file for each time step; empty for other volumes.
std::vector<std::filesystem::path> filesOfSteps(VolumeSource& source) {
  const int64_t steps = source.layout().time_steps;
  if (steps < 2) return {};
  const std::vector<std::string> files = source.files();
  if (static_cast<int64_t>(files.size()) != steps) return {};
  return {files.begin(), files.end()};
}

}  // namespace

std::optional<std::string> missingStep(VolumeSource& source, int64_t time) {
  const int64_t beyond = std::max<int64_t>(0, time + 1 - source.layout().time_steps);
  const auto file = missingFile(filesOfSteps(source), beyond);
  return file ? std::optional(file->string()) : std::nullopt;
}

std::optional<int64_t> stepOfNumber(VolumeSource& source, int64_t number) {
  const auto step = fileOfNumber(filesOfSteps(source), number);
  return step ? std::optional(static_cast<int64_t>(*step)) : std::nullopt;
}

}  // namespace sluice

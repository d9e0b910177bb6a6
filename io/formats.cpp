#include "io/formats.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/ranges.h>

#include "io/dicom/dicom_folder.h"
#include "io/dicom/dicom_header.h"
#include "io/dicom/dicom_source.h"
#include "io/files/file_list.h"
#include "io/hdf5/bdv_xml.h"
#include "io/hdf5/hdf5_images.h"
#include "io/hdf5/hdf5_input.h"
#include "io/hdf5/hdf5_volume.h"
#include "io/headers/meta_image/meta_image.h"
#include "io/headers/nifti/nifti.h"
#include "io/headers/nrrd/nrrd.h"
#include "io/headers/raw/raw.h"
#include "io/headers/raw/raw_name.h"
#include "io/relabelled.h"
#include "io/sequence.h"
#include "io/slices/slice_picture.h"
#include "io/slices/slice_stack.h"
#include "io/synth/synth_source.h"
#include "io/vdb/vdb_series.h"
#include "io/vdb/vdb_source.h"
#include "io/vtk/vtk_image.h"
#include "io/vtk/vtk_source.h"
#include "io/web/address.h"
#include "io/zarr/metadata/zarr_folder.h"
#include "io/zarr/n5/n5_volume.h"
#include "io/zarr/reading/zarr_source.h"
#include "src/base/error.h"
#include "src/base/sources/volume_source.h"

namespace sluice {
namespace {

using namespace std::string_view_literals;
namespace fs = std::filesystem;
using Source = std::unique_ptr<VolumeSource>;

bool hasAt(const std::string& head, size_t at, std::string_view magic) {
  return head.size() >= at + magic.size() &&
         std::string_view(head).substr(at, magic.size()) == magic;
}

bool isMetaImage(const std::string& head) {
  const std::string_view first_line = std::string_view(head).substr(0, head.find('\n'));
  return first_line.find('=') != std::string_view::npos &&
         first_line.find('\0') == std::string_view::npos &&
         head.find("DimSize") != std::string::npos;
}

bool isNifti(const std::string& head) {
  constexpr size_t kNifti1MagicAt = 344, kNifti2MagicAt = 4;
  return hasAt(head, kNifti1MagicAt, "n+1\0"sv) || hasAt(head, kNifti1MagicAt, "ni1\0"sv) ||
         hasAt(head, kNifti2MagicAt, "n+2\0"sv) || hasAt(head, kNifti2MagicAt, "ni2\0"sv);
}

// Voxels of NIfTI's older form, with their header beside them.
bool areNiftiVoxels(const NamedInput& input, const OpenOptions& /*options*/) {
  fs::path voxels = input.file;
  const std::string ending = lowerExtension(voxels);
  if (ending != ".img" && ending != ".img.gz") return false;
  if (ending == ".img.gz") voxels.replace_extension();
  voxels.replace_extension(".hdr");
  std::error_code ignored;
  return fs::exists(voxels, ignored) || fs::exists(voxels.string() + ".gz", ignored);
}

bool areSlicesWithoutHeaders(const NamedInput& input, const OpenOptions& options) {
  return input.is_folder && options.dims && options.type;
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
          .decode = decodeOptionsOf(options),
          .is_over = options.channel.is_over};
}

SliceOptions sliceOptions(const OpenOptions& options) {
  return {.spacing = options.spacing, .channel = options.channel, .stop = options.stop};
}

bool isRawName(const NamedInput& input, const OpenOptions& options) {
  const std::string ending = lowerExtension(input.file);
  return ending == ".img" || ending == ".img.gz" || options.dims || options.type ||
         parseRawName(input.file.filename().string()).dims;
}

Source openRawOrSlices(const NamedInput& input, const OpenOptions& options) {
  return input.is_folder ? openRawSlices(listFolder(input.file), rawOptions(options))
                         : openRaw(input.file, rawOptions(options));
}

// Raw files each of which has the bytes of one slice of --dims.
Source joinRawSlices(const std::vector<std::string>& files, const OpenOptions& options) {
  if (!options.dims || !options.type || !isCountable(*options.dims) ||
      static_cast<size_t>(options.dims->z) != files.size())
    return nullptr;
  std::error_code unknown;
  const auto slice_bytes =
      static_cast<uint64_t>(options.dims->x * options.dims->y) * bytesPerVoxel(*options.type);
  if (fs::file_size(files[0], unknown) != slice_bytes + static_cast<uint64_t>(options.skip_bytes))
    return nullptr;
  return openRawSlices({files.begin(), files.end()}, rawOptions(options));
}

// Whether the options or the name give the size and type of voxels without a header.
bool isStatedRaw(const NamedInput& input, const OpenOptions& options) {
  const RawName name = parseRawName(input.file.filename().string());
  const std::string ending = lowerExtension(input.file);
  return (options.dims || name.dims) && (options.type || name.type) && ending != ".dcm" &&
         ending != ".dicom";
}

bool isDicom(const NamedInput& input, const OpenOptions& options) {
  if (input.is_folder) return !areSlicesWithoutHeaders(input, options) && isDicomFolder(input.file);
  // A raw file that the user describes may look like elements without a preamble.
  return hasAt(input.head, kDicomPreambleBytes, "DICM") ||
         (!isStatedRaw(input, options) && looksLikeDicom(input.head));
}

DicomOptions dicomOptions(const OpenOptions& options) {
  return {.series = options.grid, .stop = options.stop};
}

Source openDicom(const NamedInput& input, const OpenOptions& options) {
  return input.is_folder ? openDicomFolder(input.file, dicomOptions(options))
                         : openDicomFiles({input.file}, dicomOptions(options));
}

// Slices of any number of series.
Source joinDicom(const std::vector<std::string>& files, const OpenOptions& options) {
  for (const std::string& file : files)
    if (const NamedInput input = lookAt(file, options); input.is_folder || !isDicom(input, options))
      return nullptr;
  return openDicomFiles({files.begin(), files.end()}, dicomOptions(options));
}

// Any other folder is one of slices.
bool arePictures(const NamedInput& input, const OpenOptions& options) {
  if (input.is_folder) return !areSlicesWithoutHeaders(input, options);
  return !input.head.empty() && isSlicePicture(input.file);
}

Source openPictures(const NamedInput& input, const OpenOptions& options) {
  return input.is_folder ? openSliceFolder(input.file, sliceOptions(options))
                         : openSlices({input.file}, sliceOptions(options));
}

// Pictures of one page, or of a set of OME-TIFF files.
Source joinPictures(const std::vector<std::string>& files, const OpenOptions& options) {
  const NamedInput first = lookAt(files[0], options);
  if (first.is_folder || !arePictures(first, options)) return nullptr;
  const PictureFormat format = openSlicePicture(first.file)->format();
  const bool is_of_set = !format.order.files.empty() || !format.order.companion.empty();
  if (format.pages != 1 && !is_of_set) return nullptr;
  return openSlices({files.begin(), files.end()}, sliceOptions(options));
}

bool isVdb(const NamedInput& input, const OpenOptions& /*options*/) {
  return hasAt(input.head, 0, " BDV");
}

// The time steps of a series in the box around all of them.
Source joinVdb(const std::vector<std::string>& files, const OpenOptions& options) {
  for (const std::string& file : files) {
    if (!isVdb(lookAt(file, options), options)) return nullptr;
  }
  const std::vector<Box3> boxes =
      vdbSeriesBoxes({files.begin(), files.end()}, options.grid, options.stop);
  std::map<std::string, Box3> box_of;
  for (size_t i = 0; i < files.size(); ++i) box_of[files[i]] = boxes[i];
  return std::make_unique<SequenceSource>(
      files, [grid = options.grid, spacing = options.spacing, box_of](
                 const std::string& file, const std::optional<ChannelWish>& /*channel*/) {
        return respaced(openVdb(file, grid, box_of.at(file)), spacing);
      });
}

bool isZarrStore(const NamedInput& input, const OpenOptions& /*options*/) {
  return input.store && isZarr(*input.store);
}

ChunkedOptions chunkedOptions(const OpenOptions& options) {
  return {.channel = options.channel, .chunk_cache_bytes = options.chunk_cache_bytes};
}

const StorePlace& storeOf(const NamedInput& input) {
  if (!input.store)
    fail("{}: expected a folder or a zip file, found a file of another kind", input.file.string());
  return *input.store;
}

Source openZarr(const NamedInput& input, const OpenOptions& options) {
  return std::make_unique<ZarrSource>(storeOf(input), chunkedOptions(options));
}

bool isN5Store(const NamedInput& input, const OpenOptions& /*options*/) {
  return input.store && isN5(*input.store);
}

Source openN5(const NamedInput& input, const OpenOptions& options) {
  return std::make_unique<ChunkedSource>(n5Volume(storeOf(input)), chunkedOptions(options));
}

// One row a format. The first that holds the content opens it, or else the first that has the name.
std::vector<Format> makeFormats() {
  using In = const NamedInput&;
  using Given = const OpenOptions&;
  return {
      {.holds = [](In input, Given) { return isSynthSpec(input.name); },
       .open = [](In input, Given) -> Source { return openSynth(parseSynthSpec(input.name)); }},
      {.name = "NRRD",
       .endings = {".nrrd", ".nhdr"},
       .holds = [](In input, Given) { return hasAt(input.head, 0, "NRRD"); },
       .open = [](In input, Given given) { return openNrrd(input.file, decodeOptionsOf(given)); }},
      {.name = "MetaImage",
       .endings = {".mhd", ".mha"},
       .holds = [](In input, Given) { return isMetaImage(input.head); },
       .open = [](In input,
                  Given given) { return openMetaImage(input.file, decodeOptionsOf(given)); }},
      {.name = "NIfTI",
       .endings = {".nii", ".nii.gz", ".hdr", ".hdr.gz"},
       .holds = [](In input, Given) { return isNifti(input.head); },
       .named = areNiftiVoxels,
       .open = [](In input, Given given) { return openNifti(input.file, decodeOptionsOf(given)); }},
      {.name = "VTK (.vti, .vtk)",
       .plural = "VTK images",
       .takes = {.channel = true},
       .endings = {".vti", ".vtk"},
       .holds =
           [](In input, Given) {
             return isLegacyVtk(input.head) || (isVti(input.head) && !input.is_folder);
           },
       .open =
           [](In input, Given given) {
             return openVtk(input.file, given.channel, decodeOptionsOf(given));
           }},
      {.name = "HDF5 (FILE.h5:/SET)",
       .plural = "HDF5 files",
       .takes = {.channel = true},
       .endings = {".h5", ".hdf5", ".nc", ".ims"},
       .holds = [](In input, Given) { return isHdf5(input.head); },
       .open =
           [](In input, Given given) {
             return openHdf5(input.file, input.inside, chunkedOptions(given));
           }},
      {.name = "BigDataViewer's .xml",
       .plural = "BigDataViewer's images",
       .takes = {.channel = true},
       .endings = {".xml"},
       .holds = [](In input, Given) { return isBdvXml(input.head); },
       .open = [](In input,
                  Given given) { return openBdvXml(input.file.string(), chunkedOptions(given)); }},
      {.name = "OpenVDB",
       .plural = "OpenVDB files",
       .takes = {.grid = true},
       .endings = {".vdb"},
       .holds = isVdb,
       .open = [](In input, Given given) { return openVdb(input.file, given.grid); },
       .join = joinVdb},
      {.name = "Zarr",
       .plural = "Zarr stores",
       .takes = {.channel = true},
       .endings = {".zarr", ".zip", ".ozx"},
       .holds = isZarrStore,
       .open = openZarr},
      {.name = "N5",
       .plural = "N5 groups",
       .takes = {.channel = true},
       .endings = {".n5"},
       .holds = isN5Store,
       .open = openN5},
      {.name = "DICOM",
       .plural = "DICOM images",
       .takes = {.grid = true},
       .endings = {".dcm", ".dicom"},
       .holds = isDicom,
       .open = openDicom,
       .join = joinDicom},
      {.name = "PNG or TIFF slices",
       .plural = "TIFF files",
       .takes = {.channel = true},
       .endings = {".png", ".tif", ".tiff"},
       .holds = arePictures,
       .open = openPictures,
       .join = joinPictures},
      {.name = "raw with --dims X,Y,Z --type T",
       .plural = "raw files",
       .takes = {.description = true},
       .endings = {".raw", ".raw.gz"},
       .holds = areSlicesWithoutHeaders,
       .named = isRawName,
       .open = openRawOrSlices,
       .join = joinRawSlices},
  };
}

// The volumes of the formats that take an option: "Zarr stores and TIFF files".
std::string takers(bool Format::Takes::*option) {
  std::vector<std::string_view> names;
  for (const Format& format : formats()) {
    if (format.takes.*option) names.push_back(format.plural);
  }
  return fmt::format("{}{}{}", fmt::join(names.begin(), names.end() - 1, ", "),
                     names.size() > 1 ? " and " : "", names.back());
}

std::string understood() {
  std::vector<std::string_view> names;
  for (const Format& format : formats()) {
    if (!format.name.empty()) names.push_back(format.name);
  }
  return fmt::format("{} or {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

bool isNamed(const Format& format, const NamedInput& input, const OpenOptions& options) {
  const std::string ending = lowerExtension(input.file);
  return std::find(format.endings.begin(), format.endings.end(), ending) != format.endings.end() ||
         (format.named != nullptr && format.named(input, options));
}

}  // namespace

std::span<const Format> formats() {
  static const std::vector<Format> all = makeFormats();
  return all;
}

const Format& formatOf(const NamedInput& input, const OpenOptions& options) {
  // The content decides first: names are often wrong, and a file is read for what it holds.
  for (const Format& format : formats()) {
    if (format.holds(input, options)) return format;
  }
  if (isAddress(input.name))
    fail(
        "{}: expected a Zarr or N5 store, found none of zarr.json, .zarray, .zgroup and "
        "attributes.json there; download files of other kinds first",
        input.store->name());
  if (input.store && !input.is_folder)
    fail(
        "{}: expected a Zarr or N5 store in the zip file, found none of zarr.json, .zarray, "
        ".zgroup and attributes.json there; name the folder that has it, as in '{}:/FOLDER', or "
        "unpack the file",
        input.store->name(), input.file.string());
  for (const Format& format : formats())
    if (isNamed(format, input, options)) return format;
  const std::string expected = understood();
  throw UnknownFormat(fmt::format("{}: unknown kind of file, expected {}", input.name, expected),
                      Error::Kind::kInput);
}

void requireTaken(const std::string& name, const Format& format, const OpenOptions& options) {
  const bool is_described = options.dims || options.time_steps || options.type ||
                            options.byte_order || options.skip_bytes != 0;
  if (is_described && !format.takes.description)
    failRequest(
        "{}: the file contains its size and type; leave out --dims, --type, --endian and --skip, "
        "which are for raw files{}",
        name,
        options.has_over ? " and describe the first volume; a raw file of --over is described by "
                           "its name, such as head_256x256x225_uint8.raw"
                         : "");
  if (!options.grid.empty() && !format.takes.grid)
    failRequest("{}: --grid {} is for {}, which this is not; leave it out", name, options.grid,
                takers(&Format::Takes::grid));
  if (options.channel.given() && !format.takes.channel)
    failRequest("{}: --channel {} is for {}, which this is not; leave it out", name,
                options.channel.text(), takers(&Format::Takes::channel));
  if (!options.spacing) return;
  const Vec3d s = *options.spacing;
  for (int a = 0; a < 3; ++a)
    if (!(s[a] > 0) || !std::isfinite(s[a]))
      fail("{}: spacing {}, {}, {}, expected three positive numbers", name, s.x, s.y, s.z);
}

std::vector<std::string> volumeEndings() {
  std::vector<std::string> all;
  for (const Format& format : formats())
    all.insert(all.end(), format.endings.begin(), format.endings.end());
  return all;
}

}  // namespace sluice

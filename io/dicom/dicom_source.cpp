#include "io/dicom/dicom_source.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <optional>
#include <string_view>
#include <utility>

#include "io/dicom/dicom_folder.h"
#include "io/dicom/dicom_frames.h"
#include "io/dicom/dicom_module.h"
#include "io/dicom/dicom_order.h"
#include "io/dicom/dicom_stack.h"
#include "io/files/file.h"
#include "io/files/file_list.h"
#include "io/files/plane_bands.h"
#include "src/base/error.h"
#include "src/base/files/program_module.h"
#include "src/base/sources/read_units.h"
#include "src/base/sources/region_check.h"
#include "src/base/sources/stored_reads.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

DecodeDicomFrame* openDecoder(const std::string& volume) {
  try {
    return openModule({"sluice_dicom.so", "sluice's module for compressed DICOM images",
                       kDicomModuleVersionName, kDicomModuleVersion})
        .get<DecodeDicomFrame*>(kDecodeDicomFrame);
  } catch (const Error& error) {
    failAs(error.kind(), "{}: a compressed DICOM image, which is not read without {}", volume,
           error.what());
  }
}

class DicomSource final : public VolumeSource, public UnitSource, public StoredSource {
 public:
  DicomSource(std::vector<DicomHeader> headers, const std::string& path,
              const DicomOptions& options)
      : stop_(options.stop) {
    const std::vector<DicomStack> stacks = findDicomStacks(headers);
    std::vector<std::string> notes;
    const DicomStack& stack = chooseDicomStack(path, stacks, options.series, notes);
    for (const DicomFrame& frame : stack.frames) requireDicomPixels(headers[frame.file]);
    form_ = stack.form;
    DicomVolume volume = orderDicomStack(headers, stack);
    layout_ = std::move(volume.layout);
    layout_.name = fmt::format("{} series {}", stack.modality, stack.name);
    layout_.path = path;
    for (const DicomStack& one : stacks) layout_.grids.push_back(one.name);
    layout_.notes.insert(layout_.notes.begin(), notes.begin(), notes.end());
    lines_ = std::move(volume.lines);
    openFiles(headers, volume.frames);
    noteColors(headers[volume.frames[0].file]);
    makeBands();
    holdAtMost(options.held_bytes);
  }

  const VolumeLayout& layout() const override { return layout_; }
  std::string identity() const override { return identity_; }
  std::vector<std::string> files() override {
    std::vector<std::string> all;
    for (const auto& file : files_) all.push_back(file.file->path());
    return all;
  }
  uint64_t storedBytesRead() const override { return read_bytes_.load(); }
  ReadUnits readUnits() const override { return {.voxels = {layout_.dims.x, layout_.dims.y, 1}}; }
  uint64_t heldBytesAThread() const override { return decoder_bytes_ + 2 * bands_->bandBytes(); }
  void holdAtMost(uint64_t bytes) override { bands_->holdAtMost(bytes); }
  std::optional<StoredReads> storedReads(int64_t /*time*/, std::span<const LevelBox> boxes,
                                         uint64_t held_bytes) override {
    // Frames that are not compressed are read, not decoded.
    if (most_code_bytes_ == 0) return std::nullopt;
    std::vector<Box3> read;
    for (const LevelBox& box : boxes) read.push_back(box.box);
    return bands_->storedReads(std::move(read), held_bytes);
  }

  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    const RegionRead region{box, out};
    readRegions(time, std::span(&region, 1));
  }
  void readRegions(int64_t time, std::span<const RegionRead> regions) override {
    for (const RegionRead& region : regions) checkRegion(layout_, time, region.box, region.out);
    bands_->copy(regions, bytesPerVoxel(layout_.type), [&](int64_t z) {
      stop_.throwIfStopped();
      return time * layout_.dims.z + z;
    });
  }

 private:
  // A file of the stack, and the parts of its header that decoding needs.
  struct OpenFile {
    std::unique_ptr<File> file;
    DicomHeader header;  // without functions
  };
  struct Slice {
    size_t file = 0;
    DicomPlace place;
  };

  bool isPlain(const OpenFile& file) const { return file.header.coding == DicomCoding::kPlain; }

  DicomInput inputOf(File& file) {
    return {file.path(), file.sizeBytes(), [this, &file](uint64_t at, std::span<std::byte> out) {
              const size_t got = file.readSome(at, out);
              read_bytes_ += got;
              return got;
            }};
  }

  // The files of the frames alone, each once, and the places of the frames in them.
  void openFiles(std::vector<DicomHeader>& headers, const std::vector<DicomFrame>& frames) {
    constexpr size_t kMostFilesOpen = 64;
    constexpr size_t kNone = SIZE_MAX;
    std::vector<size_t> number(headers.size(), kNone);
    std::vector<fs::path> paths;
    for (const DicomFrame& frame : frames) {
      if (number[frame.file] != kNone) continue;
      number[frame.file] = paths.size();
      paths.emplace_back(headers[frame.file].path);
    }
    // A series may have more files than a process may open.
    const File::Keep keep = paths.size() > kMostFilesOpen ? File::Keep::kClosed : File::Keep::kOpen;
    std::vector<std::vector<DicomPlace>> places(paths.size());
    files_.resize(paths.size());
    for (const DicomFrame& frame : frames) {
      const size_t at = number[frame.file];
      if (files_[at].file == nullptr) {
        stop_.throwIfStopped();
        files_[at].file = std::make_unique<File>(paths[at], keep);
        DicomHeader& header = files_[at].header = headers[frame.file];
        header.per_frame.clear();
        places[at] = dicomPlaces(inputOf(*files_[at].file), header);
      }
      slices_.push_back({at, places[at][static_cast<size_t>(frame.frame)]});
      if (!isPlain(files_[at])) {
        const DicomPlace& place = slices_.back().place;
        most_code_bytes_ = std::max(most_code_bytes_, place.end - place.begin);
      }
    }
    identity_ = fileIdentity(paths) + "|" + layout_.name;
  }

  void noteColors(const DicomHeader& header) {
    if (form_.samples == 3)
      layout_.notes.push_back(
          fmt::format("{}: its colors are read as their luminance", header.path));
    if (header.photometric == "MONOCHROME1")
      layout_.notes.push_back(fmt::format(
          "{}: its low values are meant to be bright (MONOCHROME1); they are read as they are",
          header.path));
  }

  void makeBands() {
    const auto row_bytes = layout_.dims.x * static_cast<int64_t>(bytesPerVoxel(layout_.type));
    // Whole frames, where rows cannot be had alone.
    // Compressed frames, and colours plane by plane, are decoded as a whole.
    const bool has_rows = form_.samples == 1 && most_code_bytes_ == 0;
    const int64_t rows =
        has_rows ? PlaneBands::usualBandRows(layout_.dims.y, row_bytes, 1) : layout_.dims.y;
    const auto frame_bytes = static_cast<uint64_t>(form_.frameBytes());
    // GDCM holds the code twice and the pixels twice, its JPEG 2000 decoder four bytes a pixel.
    constexpr uint64_t kDecoderBytes = uint64_t{1} << 20;
    decoder_bytes_ = most_code_bytes_ == 0
                         ? static_cast<uint64_t>(form_.pixelBytes() * layout_.dims.x * rows)
                         : kDecoderBytes + 4 * most_code_bytes_ + 4 * frame_bytes +
                               4 * static_cast<uint64_t>(form_.columns * form_.rows);
    bands_.emplace(PlaneBands::Shape{.height = layout_.dims.y,
                                     .row_bytes = row_bytes,
                                     .band_rows = rows,
                                     .unit_rows = layout_.dims.y},
                   [this](int64_t plane, int64_t first, int64_t count, std::span<std::byte> out) {
                     decode(static_cast<size_t>(plane), first, count, out);
                   });
  }

  void decode(size_t plane, int64_t first, int64_t count, std::span<std::byte> out) {
    const Slice& slice = slices_[plane];
    OpenFile& file = files_[slice.file];
    DicomPixels pixels{.color_bytes = 1, .pixel_bytes = form_.pixelBytes()};
    std::vector<std::byte> stored;
    if (isPlain(file)) {
      const int64_t row_bytes = form_.columns * form_.pixelBytes();
      stored.resize(static_cast<size_t>(count * row_bytes));
      file.file->readAt(slice.place.begin + static_cast<uint64_t>(first * row_bytes), stored);
      read_bytes_ += stored.size();
      pixels.is_swapped =
          file.header.encoding.big_endian != (std::endian::native == std::endian::big);
    } else {
      stored.resize(static_cast<size_t>(form_.frameBytes()));
      decodeFrame(file, slice.place, stored);
    }
    const bool is_color_by_color =
        form_.samples == 3 &&
        (file.header.coding == DicomCoding::kRunLength || file.header.is_planar);
    if (is_color_by_color) {
      pixels.color_bytes = form_.columns * form_.rows;
      pixels.pixel_bytes = 1;
    }
    pixels.bytes = stored;
    const auto line = lines_.empty() ? std::nullopt : std::optional(lines_[plane]);
    convertDicomPixels(form_, pixels, line, layout_.type, count * form_.columns, out);
  }

  void decodeFrame(OpenFile& file, const DicomPlace& place, std::span<std::byte> pixels) {
    const std::string& path = file.file->path();
    const std::vector<std::byte> code = readDicomCode(inputOf(*file.file), place);
    if (file.header.coding == DicomCoding::kRunLength) {
      decodeDicomRuns(path, code, file.header, pixels);
      return;
    }
    // Overlays above the stored bits are in the stream, too.
    DicomPixelForm form = form_;
    form.bits_stored = checkedStreamBits(path, code, file.header);
    form.high_bit = form.bits_stored - 1;
    // The module is opened at the first compressed frame, so that plain series do not need it.
    static DecodeDicomFrame* const decode = openDecoder(path);
    if (!decode(file.header.coding, form, code, pixels))
      fail("{}: damaged DICOM file: a frame of {} bytes cannot be decompressed", path, code.size());
  }

  const StopToken stop_;
  std::atomic<uint64_t> read_bytes_{0};
  DicomPixelForm form_;  // constant after construction, as all that follows
  VolumeLayout layout_;
  std::string identity_;
  std::vector<DicomLine> lines_;
  std::vector<OpenFile> files_;
  std::vector<Slice> slices_;  // of all time steps
  uint64_t most_code_bytes_ = 0;
  uint64_t decoder_bytes_ = 0;
  std::optional<PlaneBands> bands_;
};

}  // namespace

std::unique_ptr<VolumeSource> openDicomFolder(const fs::path& folder, const DicomOptions& options) {
  return std::make_unique<DicomSource>(readDicomHeaders(folder, options.stop), folder.string(),
                                       options);
}

std::unique_ptr<VolumeSource> openDicomFiles(const std::vector<fs::path>& files,
                                             const DicomOptions& options) {
  return std::make_unique<DicomSource>(readDicomHeaders(files, options.stop), files[0].string(),
                                       options);
}

}  // namespace sluice

#include "io/slices/tiff/tiff_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "io/files/missing_values.h"
#include "io/slices/tiff/tiff_description.h"
#include "io/slices/tiff/tiff_rows.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMaxTileBytes = uint64_t{64} << 20;

// Strips or tiles. A file may claim any sizes.
CodedPieces piecesOf(TIFF* tiff, const TiffPage& p) {
  const auto sizeOf = [&](uint32_t tag, int64_t of_page) {
    return std::clamp<int64_t>(tiffField<uint32_t>(tiff, tag, static_cast<uint32_t>(of_page)), 1,
                               of_page);
  };
  if (!p.is_tiled) return {sizeOf(TIFFTAG_ROWSPERSTRIP, p.height)};
  return {sizeOf(TIFFTAG_TILELENGTH, p.height),
          ceilDiv(p.width, sizeOf(TIFFTAG_TILEWIDTH, p.width))};
}

class TableReader {
 public:
  TableReader(TIFF* tiff, TiffStream& stream) : tiff_(tiff), stream_(stream) {
    tables_.file_status = stream.file.status();
    listPages();
  }

  TiffTables take() { return std::move(tables_); }

 private:
  void listPages() {
    // Pages, from 1: one whose strip is too small for uncompressed pixels, and a compressed one.
    size_t too_small = 0, compressed = 0;
    do {
      // libtiff warned while it read the table of this page.
      const bool replaced = std::exchange(stream_.strip_size_replaced, false);
      if ((tiffField<uint32_t>(tiff_, TIFFTAG_SUBFILETYPE, 0) & FILETYPE_REDUCEDIMAGE) != 0)
        continue;
      const TiffPage p = tiffPageOf(tiff_);
      const PictureFormat format = tiffFormatOf(tiff_, p, stream_.file.path());
      if (tables_.pages.empty()) {
        tables_.format = format;
        readDescription();
      } else if (format.width != tables_.format.width || format.height != tables_.format.height ||
                 format.type != tables_.format.type) {
        fail("{}: page {} is {} x {} of {}, expected {} x {} of {} as on page 1",
             stream_.file.path(), tables_.pages.size() + 1, format.width, format.height,
             name(format.type), tables_.format.width, tables_.format.height,
             name(tables_.format.type));
      }
      tables_.pages.push_back(p);
      tables_.reduced.push_back(reducedDirectoriesOf(tiff_));
      const bool is_plain = p.compression == COMPRESSION_NONE;
      if (is_plain && replaced && too_small == 0) too_small = tables_.pages.size();
      if (!is_plain && compressed == 0) compressed = tables_.pages.size();
    } while (TIFFReadDirectory(tiff_) != 0);
    // The loop ends at the last table or at a damaged one; only the handler's message tells which.
    if (!stream_.failure.message.empty()) stream_.failWith("damaged TIFF");
    if (too_small != 0 && compressed != 0)
      fail(
          "{}: page {} has fewer bytes than its uncompressed pixels take, and page {} is "
          "compressed; expected the compression of page {} named on both, the file is damaged",
          stream_.file.path(), too_small, compressed, compressed);
    if (tables_.pages.empty()) stream_.failWith("TIFF without a picture of full size");
    tables_.format.order = parseTiffDescription(
        description_, static_cast<int64_t>(tables_.pages.size()), resolution_[0], resolution_[1]);
    if (tables_.format.order.untold_pages > 0) addUntoldPages();
    tables_.format.pages = static_cast<int64_t>(tables_.pages.size());
    listReduced();
    noteColors();
    tables_.format.open_bytes = openBytes();
  }

  // Adds the image at whose table libtiff stands. Returns why it is no smaller picture of page 1;
  // empty: it is.
  std::string addReduced() {
    PictureFormat format;
    try {
      format = tiffFormatOf(tiff_, tiffPageOf(tiff_), stream_.file.path());
    } catch (const Error& error) {
      return error.what();
    }
    const bool is_first = tables_.format.reduced.empty();
    const int64_t width = is_first ? tables_.format.width : tables_.format.reduced.back().width;
    const int64_t height = is_first ? tables_.format.height : tables_.format.reduced.back().height;
    if (format.type != tables_.format.type)
      return fmt::format("its pixels are {}, expected {}", name(format.type),
                         name(tables_.format.type));
    if (format.width > width || format.height > height ||
        (format.width == width && format.height == height))
      return fmt::format("it has {} x {} pixels, the one before it {} x {}", format.width,
                         format.height, width, height);
    tables_.format.reduced.push_back(
        {format.width, format.height, format.unit_rows, format.pieces});
    return "";
  }

  // The sizes of the reduced images that each page has.
  void listReduced() {
    if (tables_.format.order.untold_pages > 0) return;
    const size_t levels = tables_.reduced[0].size();
    for (size_t i = 1; i < tables_.reduced.size(); ++i)
      if (tables_.reduced[i].size() != levels) {
        tables_.format.notes.push_back(
            fmt::format("page {} has {} reduced images, page 1 has {}; they are left out", i + 1,
                        tables_.reduced[i].size(), levels));
        return;
      }
    for (const uint64_t directory : tables_.reduced[0]) {
      std::string fault = "its table is damaged";
      if (TIFFSetSubDirectory(tiff_, directory) != 0) fault = addReduced();
      // A damaged level is left out, so that its message must not end up in a later failure.
      stream_.failure = {};
      if (fault.empty()) continue;
      tables_.format.notes.push_back(
          fmt::format("reduced image {} of page 1 is left out, and smaller ones: {}",
                      tables_.format.reduced.size() + 1, fault));
      return;
    }
  }

  // Reads the description of the first page, in which writers describe the whole file.
  void readDescription() {
    const char* text = nullptr;
    if (TIFFGetField(tiff_, TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr)
      description_ = text;
    const auto unit = tiffField<uint16_t>(tiff_, TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
    // Pixels per inch or centimeter are meant for printers, unless the text tells otherwise.
    resolution_ = {tiffField<float>(tiff_, TIFFTAG_XRESOLUTION, 0),
                   tiffField<float>(tiff_, TIFFTAG_YRESOLUTION, 0)};
    const bool is_imagej = description_.starts_with("ImageJ=");
    // ImageJ names the unit in its lines; dots per inch without one are those of a printer.
    const bool has_unit = is_imagej && description_.find("\nunit=") != std::string::npos;
    if (unit == RESUNIT_INCH ? !has_unit : is_imagej && !has_unit && unit != RESUNIT_NONE)
      resolution_ = {};
  }

  // ImageJ writes stacks beyond 4 GiB as one page, behind which the others lie one by one, and
  // tifffile those that are truncated.
  void addUntoldPages() {
    const TiffPage first = tables_.pages[0];
    const uint64_t page_bytes = uint64_t{first.width} * first.height * first.pixelBytes();
    const uint64_t begin = TIFFGetStrileOffset(tiff_, 0), size = stream_.file.sizeBytes();
    const auto pages = static_cast<uint64_t>(tables_.format.order.untold_pages) + 1;
    if (first.is_tiled || first.compression != COMPRESSION_NONE || begin > size ||
        pages > (size - begin) / page_bytes)
      fail(
          "{}: its description names {} images of {} bytes, expected them uncompressed "
          "behind the first, in a file of {} bytes from {} on; the file was truncated or converted",
          stream_.file.path(), pages, page_bytes, size, begin);
    for (uint64_t i = 1; i < pages; ++i) {
      tables_.pages.push_back(first);
      tables_.pages.back().moved_bytes = i * page_bytes;
    }
  }

  void noteColors() {
    const TiffPage& p = tables_.pages[0];
    tables_.format.blanked = blankedNumbers(tables_.format.type, p.missingValues());
    VolumeLayout layout;
    layout.type = tables_.format.type;
    const bool is_scaled = p.value_scale != 1 || p.value_offset != 0;
    constexpr double kMostValue = 1e30;
    const double size = std::abs(p.value_scale);
    const bool is_usable = size >= 1 / kMostValue && size <= kMostValue &&
                           std::abs(p.value_offset) <= kMostValue &&
                           p.photometric == PHOTOMETRIC_MINISBLACK;
    if (is_scaled && is_usable) {
      layout.value_scale = tables_.format.value_scale = p.value_scale;
      layout.value_offset = tables_.format.value_offset = p.value_offset;
    } else if (is_scaled) {
      tables_.format.notes.push_back(fmt::format(
          "its values are drawn as stored, without the scale {:g} and the offset {:g} of its "
          "metadata",
          p.value_scale, p.value_offset));
    }
    // Integers that are converted have other values.
    if (const std::string note = missingValuesNote(p.missingValues(), layout, "GDAL_NODATA");
        !note.empty() && p.photometric == PHOTOMETRIC_MINISBLACK)
      tables_.format.notes.push_back(note);
    if (p.hasColor())
      tables_.format.notes.emplace_back("its colors are read as their luminance");
    else if (p.samples > 1)
      tables_.format.notes.push_back(
          fmt::format("the first of {} samples a pixel is read", p.samples));
  }

  // libtiff holds a compressed strip or tile whole, and its tables.
  uint64_t openBytes() {
    // A failure to go back to the first table is one of the file.
    if (TIFFSetSubDirectory(tiff_, tables_.pages[0].directory) == 0)
      stream_.failWith("damaged TIFF");
    const TiffPage& p = tables_.pages[0];
    constexpr uint64_t kDecoderBytes = uint64_t{128} << 10;
    uint64_t bytes = kDecoderBytes + tables_.pages.size() * sizeof(TiffPage);
    const uint64_t strips = p.is_tiled ? TIFFNumberOfTiles(tiff_) : TIFFNumberOfStrips(tiff_);
    bytes += strips * 2 * sizeof(uint64_t);
    uint64_t largest = 0;
    // Uncompressed strips are read in pieces by ourselves; libtiff holds none of them.
    if (p.compression != COMPRESSION_NONE || p.is_tiled)
      for (uint64_t i = 0; i < strips; ++i)
        largest =
            std::max<uint64_t>(largest, TIFFGetStrileByteCount(tiff_, static_cast<uint32_t>(i)));
    bytes += std::min(largest, stream_.file.sizeBytes());
    const uint64_t row_bytes = p.width * p.pixelBytes();
    if (p.is_tiled) return bytes + TIFFTileSize64(tiff_) + tables_.format.unit_rows * row_bytes;
    return bytes + std::max<uint64_t>(row_bytes, TiffRows::kPlainBytes);
  }

  TIFF* const tiff_;
  TiffStream& stream_;
  TiffTables tables_;
  std::string description_;             // from the first page
  std::array<double, 2> resolution_{};  // pixels a unit; 0 if the file does not tell
};

}  // namespace

PictureFormat tiffFormatOf(TIFF* tiff, const TiffPage& p, const std::string& path) {
  PictureFormat format;
  format.width = p.width;
  format.height = p.height;
  if (p.width < 1 || p.height < 1 || p.width > PictureFormat::kMaxSide ||
      p.height > PictureFormat::kMaxSide)
    fail("{}: TIFF of {} x {} pixels, expected 1 to {} a side", path, p.width, p.height,
         PictureFormat::kMaxSide);
  format.type = voxelTypeOf(p, path);
  if (p.orientation > ORIENTATION_BOTLEFT)
    fail("{}: TIFF with transposed rows and columns (orientation {}), expected 1 to 4", path,
         p.orientation);
  if (p.is_tiled) {
    const uint64_t tile_bytes = TIFFTileSize64(tiff);
    if (tile_bytes == 0 || tile_bytes > kMaxTileBytes)
      fail("{}: TIFF with tiles of {} bytes, expected at most {}", path, tile_bytes, kMaxTileBytes);
    format.unit_rows = tiffField<uint32_t>(tiff, TIFFTAG_TILELENGTH, 1);
  }
  if (p.compression != COMPRESSION_NONE) format.pieces = piecesOf(tiff, p);
  return format;
}

std::shared_ptr<const TiffTables> readTiffTables(TIFF* tiff, TiffStream& stream) {
  return std::make_shared<const TiffTables>(TableReader(tiff, stream).take());
}

}  // namespace sluice

#include "io/slices/tiff/tiff_slice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "io/files/missing_values.h"
#include "io/slices/tiff/tiff_description.h"
#include "io/slices/tiff/tiff_page.h"
#include "io/slices/tiff/tiff_rows.h"
#include "io/slices/tiff/tiff_samples.h"
#include "io/slices/tiff/tiff_stream.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMaxTileBytes = uint64_t{64} << 20;

class TiffPicture final : public SlicePicture {
 public:
  explicit TiffPicture(const std::filesystem::path& path)
      : stream_(path), tiff_(openTiff(stream_)) {
    listPages();
  }

  const PictureFormat& format() const override { return format_; }
  uint64_t storedBytesRead() const override { return stream_.file.storedBytesRead(); }

  void readRows(int64_t page, size_t level, int64_t first, int64_t count,
                std::span<std::byte> out) override {
    SLUICE_CHECK(page >= 0 && page < format_.pages);
    SLUICE_CHECK(level <= format_.reduced.size());
    goTo(page, level);
    const TiffPage& p = at_page_;
    const size_t row_bytes = size_t{p.width} * bytesPerVoxel(format_.type);
    SLUICE_CHECK(first >= 0 && count >= 0 && first + count <= p.height);
    SLUICE_CHECK_EQ(out.size(), row_bytes * static_cast<size_t>(count));
    const bool is_upside_down =
        p.orientation == ORIENTATION_BOTLEFT || p.orientation == ORIENTATION_BOTRIGHT;
    const bool is_mirrored =
        p.orientation == ORIENTATION_TOPRIGHT || p.orientation == ORIENTATION_BOTRIGHT;
    // Rows are decoded as stored, so that a strip's decoder goes on without starting anew.
    if (is_upside_down) first = p.height - first - count;
    const auto keepRow = [&](int64_t row, const std::byte* stored) {
      const int64_t at = is_upside_down ? first + count - 1 - row : row - first;
      convertPixels(p, format_.type, palette_, stored,
                    out.subspan(static_cast<size_t>(at) * row_bytes, row_bytes), is_mirrored);
    };
    rows_.read(first, count, keepRow);
    blank(format_.type, blankedNumbers(format_.type, missingOf(p)), out);
  }

 private:
  static std::vector<double> missingOf(const TiffPage& p) {
    return p.no_data ? std::vector<double>{*p.no_data} : std::vector<double>();
  }

  void listPages() {
    // Pages, from 1: one whose strip is too small for uncompressed pixels, and a compressed one.
    size_t too_small = 0, compressed = 0;
    do {
      // libtiff warned while it read the table of this page.
      const bool replaced = std::exchange(stream_.strip_size_replaced, false);
      if ((tiffField<uint32_t>(tiff_.get(), TIFFTAG_SUBFILETYPE, 0) & FILETYPE_REDUCEDIMAGE) != 0)
        continue;
      const TiffPage p = tiffPageOf(tiff_.get());
      const PictureFormat format = formatOf(p);
      if (pages_.empty()) {
        format_ = format;
        readDescription();
      } else if (format.width != format_.width || format.height != format_.height ||
                 format.type != format_.type) {
        fail("{}: page {} is {} x {} of {}, expected {} x {} of {} as on page 1",
             stream_.file.path(), pages_.size() + 1, format.width, format.height, name(format.type),
             format_.width, format_.height, name(format_.type));
      }
      pages_.push_back(p);
      reduced_.push_back(reducedDirectoriesOf(tiff_.get()));
      const bool is_plain = p.compression == COMPRESSION_NONE;
      if (is_plain && replaced && too_small == 0) too_small = pages_.size();
      if (!is_plain && compressed == 0) compressed = pages_.size();
    } while (TIFFReadDirectory(tiff_.get()) != 0);
    // The loop ends at the last table or at a damaged one; only the handler's message tells which.
    if (!stream_.message.empty()) stream_.failWith("damaged TIFF");
    if (too_small != 0 && compressed != 0)
      fail(
          "{}: page {} has fewer bytes than its uncompressed pixels take, and page {} is "
          "compressed; expected the compression of page {} named on both, the file is damaged",
          stream_.file.path(), too_small, compressed, compressed);
    if (pages_.empty()) stream_.failWith("TIFF without a picture of full size");
    format_.order = parseTiffDescription(description_, static_cast<int64_t>(pages_.size()),
                                         resolution_[0], resolution_[1]);
    if (format_.order.untold_pages > 0) addUntoldPages();
    format_.pages = static_cast<int64_t>(pages_.size());
    listReduced();
    noteColors();
    format_.open_bytes = openBytes();
  }

  // Adds the image at whose table libtiff stands. Returns why it is no smaller picture of page 1;
  // empty: it is.
  std::string addReduced() {
    PictureFormat format;
    try {
      format = formatOf(tiffPageOf(tiff_.get()));
    } catch (const Error& error) {
      return error.what();
    }
    const bool is_first = format_.reduced.empty();
    const int64_t width = is_first ? format_.width : format_.reduced.back().width;
    const int64_t height = is_first ? format_.height : format_.reduced.back().height;
    if (format.type != format_.type)
      return fmt::format("its pixels are {}, expected {}", name(format.type), name(format_.type));
    if (format.width > width || format.height > height ||
        (format.width == width && format.height == height))
      return fmt::format("it has {} x {} pixels, the one before it {} x {}", format.width,
                         format.height, width, height);
    format_.reduced.push_back({format.width, format.height, format.unit_rows, format.pieces});
    return "";
  }

  // The sizes of the reduced images that each page has.
  void listReduced() {
    if (format_.order.untold_pages > 0) return;
    const size_t levels = reduced_[0].size();
    for (size_t i = 1; i < reduced_.size(); ++i)
      if (reduced_[i].size() != levels) {
        format_.notes.push_back(
            fmt::format("page {} has {} reduced images, page 1 has {}; they are left out", i + 1,
                        reduced_[i].size(), levels));
        return;
      }
    for (const uint64_t directory : reduced_[0]) {
      std::string fault = "its table is damaged";
      if (TIFFSetSubDirectory(tiff_.get(), directory) != 0) fault = addReduced();
      // A damaged level is left out, so that its message must not end up in a later failure.
      stream_.message.clear();
      if (fault.empty()) continue;
      format_.notes.push_back(
          fmt::format("reduced image {} of page 1 is left out, and smaller ones: {}",
                      format_.reduced.size() + 1, fault));
      return;
    }
  }

  // Reads the description of the first page, in which writers describe the whole file.
  void readDescription() {
    const char* text = nullptr;
    if (TIFFGetField(tiff_.get(), TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr)
      description_ = text;
    const auto unit = tiffField<uint16_t>(tiff_.get(), TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
    // Pixels per inch or centimeter are meant for printers, unless the text tells otherwise.
    resolution_ = {tiffField<float>(tiff_.get(), TIFFTAG_XRESOLUTION, 0),
                   tiffField<float>(tiff_.get(), TIFFTAG_YRESOLUTION, 0)};
    const bool is_imagej = description_.starts_with("ImageJ=");
    // ImageJ names the unit in its lines; dots per inch without one are those of a printer.
    const bool has_unit = is_imagej && description_.find("\nunit=") != std::string::npos;
    if (unit == RESUNIT_INCH ? !has_unit : is_imagej && !has_unit && unit != RESUNIT_NONE)
      resolution_ = {};
  }

  // ImageJ writes stacks beyond 4 GiB as one page, behind which the others lie one by one, and
  // tifffile those that are truncated.
  void addUntoldPages() {
    const TiffPage first = pages_[0];
    const uint64_t page_bytes = uint64_t{first.width} * first.height * first.pixelBytes();
    const uint64_t begin = TIFFGetStrileOffset(tiff_.get(), 0), size = stream_.file.sizeBytes();
    const auto pages = static_cast<uint64_t>(format_.order.untold_pages) + 1;
    if (first.is_tiled || first.compression != COMPRESSION_NONE || begin > size ||
        pages > (size - begin) / page_bytes)
      fail(
          "{}: its description names {} images of {} bytes, expected them uncompressed "
          "behind the first, in a file of {} bytes from {} on; the file was truncated or converted",
          stream_.file.path(), pages, page_bytes, size, begin);
    for (uint64_t i = 1; i < pages; ++i) {
      pages_.push_back(first);
      pages_.back().moved_bytes = i * page_bytes;
    }
  }

  void noteColors() {
    const TiffPage& p = pages_[0];
    format_.blanked = blankedNumbers(format_.type, missingOf(p));
    VolumeLayout layout;
    layout.type = format_.type;
    const bool is_scaled = p.value_scale != 1 || p.value_offset != 0;
    constexpr double kMostValue = 1e30;
    const double size = std::abs(p.value_scale);
    const bool is_usable = size >= 1 / kMostValue && size <= kMostValue &&
                           std::abs(p.value_offset) <= kMostValue &&
                           p.photometric == PHOTOMETRIC_MINISBLACK;
    if (is_scaled && is_usable) {
      layout.value_scale = format_.value_scale = p.value_scale;
      layout.value_offset = format_.value_offset = p.value_offset;
    } else if (is_scaled) {
      format_.notes.push_back(fmt::format(
          "its values are drawn as stored, without the scale {:g} and the offset {:g} of its "
          "metadata",
          p.value_scale, p.value_offset));
    }
    // Integers that are converted have other values.
    if (const std::string note = missingValuesNote(missingOf(p), layout, "GDAL_NODATA");
        !note.empty() && p.photometric == PHOTOMETRIC_MINISBLACK)
      format_.notes.push_back(note);
    if (p.hasColor())
      format_.notes.emplace_back("its colors are read as their luminance");
    else if (p.samples > 1)
      format_.notes.push_back(fmt::format("the first of {} samples a pixel is read", p.samples));
  }

  // libtiff holds a compressed strip or tile whole, and its tables.
  uint64_t openBytes() {
    goTo(0, 0);
    const TiffPage& p = pages_[0];
    constexpr uint64_t kDecoderBytes = uint64_t{128} << 10;
    uint64_t bytes = kDecoderBytes + pages_.size() * sizeof(TiffPage);
    const uint64_t strips =
        p.is_tiled ? TIFFNumberOfTiles(tiff_.get()) : TIFFNumberOfStrips(tiff_.get());
    bytes += strips * 2 * sizeof(uint64_t);
    uint64_t largest = 0;
    // Uncompressed strips are read in pieces by ourselves; libtiff holds none of them.
    if (p.compression != COMPRESSION_NONE || p.is_tiled)
      for (uint64_t i = 0; i < strips; ++i)
        largest = std::max<uint64_t>(largest,
                                     TIFFGetStrileByteCount(tiff_.get(), static_cast<uint32_t>(i)));
    bytes += std::min(largest, stream_.file.sizeBytes());
    const uint64_t row_bytes = p.width * p.pixelBytes();
    if (p.is_tiled) return bytes + TIFFTileSize64(tiff_.get()) + format_.unit_rows * row_bytes;
    return bytes + std::max<uint64_t>(row_bytes, TiffRows::kPlainBytes);
  }

  // Strips or tiles. A file may claim any sizes.
  CodedPieces piecesOf(const TiffPage& p) {
    const auto sizeOf = [&](uint32_t tag, int64_t of_page) {
      return std::clamp<int64_t>(
          tiffField<uint32_t>(tiff_.get(), tag, static_cast<uint32_t>(of_page)), 1, of_page);
    };
    if (!p.is_tiled) return {sizeOf(TIFFTAG_ROWSPERSTRIP, p.height)};
    return {sizeOf(TIFFTAG_TILELENGTH, p.height),
            ceilDiv(p.width, sizeOf(TIFFTAG_TILEWIDTH, p.width))};
  }

  PictureFormat formatOf(const TiffPage& p) {
    PictureFormat format;
    format.width = p.width;
    format.height = p.height;
    if (p.width < 1 || p.height < 1 || p.width > PictureFormat::kMaxSide ||
        p.height > PictureFormat::kMaxSide)
      fail("{}: TIFF of {} x {} pixels, expected 1 to {} a side", stream_.file.path(), p.width,
           p.height, PictureFormat::kMaxSide);
    format.type = voxelTypeOf(p, stream_.file.path());
    if (p.orientation > ORIENTATION_BOTLEFT)
      fail("{}: TIFF with transposed rows and columns (orientation {}), expected 1 to 4",
           stream_.file.path(), p.orientation);
    if (p.is_tiled) {
      const uint64_t tile_bytes = TIFFTileSize64(tiff_.get());
      if (tile_bytes == 0 || tile_bytes > kMaxTileBytes)
        fail("{}: TIFF with tiles of {} bytes, expected at most {}", stream_.file.path(),
             tile_bytes, kMaxTileBytes);
      format.unit_rows = tiffField<uint32_t>(tiff_.get(), TIFFTAG_TILELENGTH, 1);
    }
    if (p.compression != COMPRESSION_NONE) format.pieces = piecesOf(p);
    return format;
  }

  void goTo(int64_t page, size_t level) {
    if (page == page_number_ && level == level_) return;
    stream_.message.clear();
    // Stands again once the table is read: a failure leaves libtiff at another one.
    page_number_ = -1;
    const auto i = static_cast<size_t>(page);
    at_page_ = pages_[i];
    if (TIFFSetSubDirectory(tiff_.get(),
                            level == 0 ? at_page_.directory : reduced_[i][level - 1]) == 0)
      stream_.failWith("damaged TIFF");
    if (level > 0) {
      at_page_ = tiffPageOf(tiff_.get());
      const PictureFormat found = formatOf(at_page_);
      const ReducedFormat& expected = format_.reduced[level - 1];
      // Only page 1 was measured when levels were listed.
      if (found.width != expected.width || found.height != expected.height ||
          found.type != format_.type)
        fail(
            "{}: reduced image {} of page {} is {} x {} of {}, expected {} x {} of {} as on page 1",
            stream_.file.path(), level, page + 1, found.width, found.height, name(found.type),
            expected.width, expected.height, name(format_.type));
    }
    page_number_ = page;
    level_ = level;
    const TiffPage& p = at_page_;
    rows_.begin(page, p);
    if (p.photometric == PHOTOMETRIC_YCBCR)
      TIFFSetField(tiff_.get(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    if (p.photometric == PHOTOMETRIC_PALETTE) palette_ = paletteOf(tiff_.get(), stream_);
  }

  TiffStream stream_;
  const TiffPtr tiff_;
  PictureFormat format_;
  std::vector<TiffPage> pages_;
  std::vector<std::vector<uint64_t>>
      reduced_;  // tables of each page's reduced images, the largest first
  // The table at which libtiff stands.
  int64_t page_number_ = -1;
  size_t level_ = 0;
  TiffPage at_page_;
  TiffRows rows_{tiff_.get(), stream_};
  std::vector<uint8_t> palette_;        // luminance of each entry
  std::string description_;             // from the first page
  std::array<double, 2> resolution_{};  // pixels a unit; 0 if the file does not tell
};

}  // namespace

std::unique_ptr<SlicePicture> openTiff(const std::filesystem::path& path) {
  return std::make_unique<TiffPicture>(path);
}

}  // namespace sluice

#include "io/slices/tiff/tiff_slice.h"

#include <memory>
#include <utility>
#include <vector>

#include "io/files/missing_values.h"
#include "io/slices/tiff/tiff_page.h"
#include "io/slices/tiff/tiff_rows.h"
#include "io/slices/tiff/tiff_samples.h"
#include "io/slices/tiff/tiff_stream.h"
#include "io/slices/tiff/tiff_tables.h"
#include "src/base/error.h"

namespace sluice {
namespace {

class TiffPicture final : public SlicePicture {
 public:
  TiffPicture(const std::filesystem::path& path, std::shared_ptr<const TiffTables> known)
      : stream_(path), tiff_(openTiff(stream_)), tables_(std::move(known)) {
    if (tables_ == nullptr)
      tables_ = readTiffTables(tiff_.get(), stream_);
    else
      stream_.file.requireSame(tables_->file_status);
  }

  std::shared_ptr<const PictureTables> tables() const override { return tables_; }
  uint64_t storedBytesRead() const override { return stream_.file.storedBytesRead(); }

  void readRows(int64_t page, size_t level, int64_t first, int64_t count,
                std::span<std::byte> out) override {
    SLUICE_CHECK(page >= 0 && page < format().pages);
    SLUICE_CHECK(level <= format().reduced.size());
    goTo(page, level);
    const TiffPage& p = at_page_;
    const size_t row_bytes = size_t{p.width} * bytesPerVoxel(format().type);
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
      convertPixels(p, format().type, palette_, stored,
                    out.subspan(static_cast<size_t>(at) * row_bytes, row_bytes), is_mirrored);
    };
    rows_.read(first, count, keepRow);
    blank(format().type, blankedNumbers(format().type, p.missingValues()), out);
  }

 private:
  void goTo(int64_t page, size_t level) {
    if (page == page_number_ && level == level_) return;
    stream_.failure = {};
    // Stands again once the table is read: a failure leaves libtiff at another one.
    page_number_ = -1;
    const auto i = static_cast<size_t>(page);
    at_page_ = tables_->pages[i];
    if (TIFFSetSubDirectory(tiff_.get(),
                            level == 0 ? at_page_.directory : tables_->reduced[i][level - 1]) == 0)
      stream_.failWith("damaged TIFF");
    if (level > 0) {
      at_page_ = tiffPageOf(tiff_.get());
      const PictureFormat found = tiffFormatOf(tiff_.get(), at_page_, stream_.file.path());
      const ReducedFormat& expected = format().reduced[level - 1];
      // Only page 1 was measured when levels were listed.
      if (found.width != expected.width || found.height != expected.height ||
          found.type != format().type)
        fail(
            "{}: reduced image {} of page {} is {} x {} of {}, expected {} x {} of {} as on page 1",
            stream_.file.path(), level, page + 1, found.width, found.height, name(found.type),
            expected.width, expected.height, name(format().type));
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
  std::shared_ptr<const TiffTables> tables_;
  // The table at which libtiff stands.
  int64_t page_number_ = -1;
  size_t level_ = 0;
  TiffPage at_page_;
  TiffRows rows_{tiff_.get(), stream_};
  std::vector<uint8_t> palette_;  // luminance of each entry
};

}  // namespace

std::unique_ptr<SlicePicture> openTiff(const std::filesystem::path& path,
                                       const std::shared_ptr<const PictureTables>& known) {
  return std::make_unique<TiffPicture>(path, std::dynamic_pointer_cast<const TiffTables>(known));
}

}  // namespace sluice

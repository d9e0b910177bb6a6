#include "io/slices/png_slice.h"

#include <png.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <vector>

#include "io/files/file.h"
#include "io/files/luminance.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMaxInterlacedBytes = uint64_t{256} << 20;

class PngPicture final : public SlicePicture {
 public:
  explicit PngPicture(const std::filesystem::path& path) : file_(path) {
    start();
    format_.width = png_get_image_width(png_, info_);
    format_.height = png_get_image_height(png_, info_);
    format_.type = png_get_bit_depth(png_, info_) == 16 ? VoxelType::kU16 : VoxelType::kU8;
    format_.pieces.rows = format_.height;
    // libpng has two rows, one of which may become wider, and this class has a third.
    constexpr uint64_t kDecoderBytes = uint64_t{128} << 10;
    const uint64_t row_bytes = png_get_rowbytes(png_, info_);
    const bool interlaced = png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE;
    format_.open_bytes = kDecoderBytes + 4 * row_bytes;
    if (interlaced)
      format_.open_bytes +=
          std::min(row_bytes * static_cast<uint64_t>(format_.height), kMaxInterlacedBytes) +
          static_cast<uint64_t>(format_.height) * sizeof(png_bytep);
    if (png_get_channels(png_, info_) == 3 &&
        png_get_color_type(png_, info_) != PNG_COLOR_TYPE_PALETTE)
      format_.notes.emplace_back("its colors are read as their luminance");
  }
  ~PngPicture() override { stop(); }
  PngPicture(const PngPicture&) = delete;
  PngPicture& operator=(const PngPicture&) = delete;

  std::shared_ptr<const PictureTables> tables() const override { return tables_; }
  uint64_t storedBytesRead() const override { return file_.storedBytesRead(); }

  void readRows(int64_t page, size_t level, int64_t first, int64_t count,
                std::span<std::byte> out) override {
    SLUICE_CHECK_EQ(level, size_t{0});
    const size_t row_bytes = static_cast<size_t>(format_.width) * bytesPerVoxel(format_.type);
    SLUICE_CHECK_EQ(page, 0);
    SLUICE_CHECK(first >= 0 && count >= 0 && first + count <= format_.height);
    SLUICE_CHECK_EQ(out.size(), row_bytes * static_cast<size_t>(count));
    if (png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE) {
      readInterlaced(first, count, out);
      return;
    }
    // PNG has no access to rows but the first: going back means to start anew.
    if (next_row_ < 0 || first < next_row_) start();
    pixels_.resize(png_get_rowbytes(png_, info_));
    while (next_row_ < first + count) {
      // Rows before the first that is wanted are decoded all the same, since zlib's stream is one.
      decodeRow();
      if (next_row_ > first)
        convertRow(pixels_.data(),
                   out.subspan(static_cast<size_t>(next_row_ - 1 - first) * row_bytes, row_bytes));
    }
  }

 private:
  // libpng leaves by longjmp, which runs no destructors: between setjmp and the jump stand only
  // libpng's frames, our two callbacks and functions without objects to destroy.
  static void onError(png_structp png, png_const_charp text) {
    auto& self = *static_cast<PngPicture*>(png_get_error_ptr(png));
    if (self.message_[0] == '\0') std::strncpy(self.message_, text, sizeof self.message_ - 1);
    png_longjmp(png, 1);
  }
  static void onWarning(png_structp, png_const_charp) {}
  static void onRead(png_structp png, png_bytep to, size_t bytes) {
    if (!static_cast<PngPicture*>(png_get_io_ptr(png))->takeBytes(to, bytes))
      png_error(png, "the file ends too early");
  }
  bool takeBytes(png_bytep to, size_t bytes) noexcept {
    try {
      const size_t got = file_.readSome(offset_, {reinterpret_cast<std::byte*>(to), bytes});
      offset_ += got;
      return got == bytes;
    } catch (const std::exception& e) {
      std::strncpy(message_, e.what(), sizeof message_ - 1);
      return false;
    }
  }

  [[noreturn]] void failPng() {
    // The decoder is of no use after an error: the next read starts anew.
    next_row_ = -1;
    fail("{}: damaged PNG at byte {}: {}", file_.path(), offset_, message_);
  }

  void stop() { png_destroy_read_struct(&png_, &info_, nullptr); }

  // Opens the picture anew, up to its first row.
  void start() {
    stop();
    offset_ = 0;
    next_row_ = -1;
    message_[0] = '\0';
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, onError, onWarning);
    info_ = png_ == nullptr ? nullptr : png_create_info_struct(png_);
    if (info_ == nullptr) failSystem("{}: libpng cannot be used (version or memory)", file_.path());
    if (!readHeader()) {
      stop();
      failPng();
    }
    next_row_ = 0;
  }

  bool readHeader() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, this, onRead);
    // A header of a few bytes must not make libpng allocate rows of any length.
    png_set_user_limits(png_, PictureFormat::kMaxSide, PictureFormat::kMaxSide);
    // Texts, profiles and other extras tell nothing about the voxels.
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png_, info_);
    const int color_type = png_get_color_type(png_, info_);
    if (color_type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (color_type == PNG_COLOR_TYPE_GRAY && png_get_bit_depth(png_, info_) < 8)
      png_set_expand_gray_1_2_4_to_8(png_);
    if ((color_type & PNG_COLOR_MASK_ALPHA) != 0) png_set_strip_alpha(png_);
    // PNG stores 16 bits big-endian.
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  void decodeRow() {
    if (!readRow(pixels_.data(), next_row_ + 1 == format_.height)) failPng();
    ++next_row_;
  }
  // After the last row the rest of the file is read too, with its check sums: a cut there is
  // damage.
  bool readRow(png_bytep row, bool is_last) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_row(png_, row, nullptr);
    if (is_last) png_read_end(png_, nullptr);
    return true;
  }

  void readInterlaced(int64_t first, int64_t count, std::span<std::byte> out) {
    start();
    const size_t stored_bytes = png_get_rowbytes(png_, info_);
    const uint64_t total = stored_bytes * static_cast<uint64_t>(format_.height);
    if (total > kMaxInterlacedBytes)
      fail(
          "{}: interlaced PNG of {} x {} = {} bytes, which must be decoded as a whole, expected at "
          "most {}; write it without interlacing",
          file_.path(), stored_bytes, format_.height, total, kMaxInterlacedBytes);
    std::vector<png_byte> image(total);
    std::vector<png_bytep> rows(static_cast<size_t>(format_.height));
    for (size_t y = 0; y < rows.size(); ++y) rows[y] = image.data() + y * stored_bytes;
    const bool good = readImage(rows.data());
    // libpng stands at the end now, whatever rows were taken out.
    next_row_ = -1;
    if (!good) failPng();
    const size_t row_bytes = out.size() / static_cast<size_t>(count);
    for (int64_t i = 0; i < count; ++i)
      convertRow(rows[static_cast<size_t>(first + i)],
                 out.subspan(static_cast<size_t>(i) * row_bytes, row_bytes));
  }
  bool readImage(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows);
    png_read_end(png_, nullptr);
    return true;
  }

  void convertRow(const png_byte* pixels, std::span<std::byte> out) const {
    if (png_get_channels(png_, info_) == 1) {
      std::memcpy(out.data(), pixels, out.size());
    } else if (format_.type == VoxelType::kU16) {
      toLuminance<uint16_t>(pixels, out);
    } else {
      toLuminance<uint8_t>(pixels, out);
    }
  }
  template <class T>
  static void toLuminance(const png_byte* pixels, std::span<std::byte> out) {
    for (size_t i = 0; i < out.size() / sizeof(T); ++i) {
      T rgb[3];
      std::memcpy(rgb, pixels + i * sizeof rgb, sizeof rgb);
      const T value = luminance(rgb[0], rgb[1], rgb[2]);
      std::memcpy(out.data() + i * sizeof(T), &value, sizeof(T));
    }
  }

  File file_;
  const std::shared_ptr<PictureTables> tables_ = std::make_shared<PictureTables>();
  PictureFormat& format_ = tables_->format;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  uint64_t offset_ = 0;           // offset of the next byte that libpng takes
  int64_t next_row_ = -1;         // row that libpng decodes next; -1: must start anew
  std::vector<png_byte> pixels_;  // a decoded row
  char message_[160] = "";
};

}  // namespace

std::unique_ptr<SlicePicture> openPng(const std::filesystem::path& path) {
  return std::make_unique<PngPicture>(path);
}

}  // namespace sluice

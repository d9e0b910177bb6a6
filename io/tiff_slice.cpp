#include "io/tiff_slice.h"

#include <tiffio.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "io/file.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMaxTileBytes = uint64_t{64} << 20;
constexpr tmsize_t kMaxAllocationBytes = tmsize_t{1} << 30;

// What libtiff calls back into: positions, bytes, and the first thing that went wrong.
struct Stream {
  explicit Stream(const std::filesystem::path& path) : file(path) {}

  static Stream& of(thandle_t handle) { return *static_cast<Stream*>(handle); }
  static tmsize_t read(thandle_t handle, void* to, tmsize_t bytes) {
    Stream& s = of(handle);
    try {
      const size_t got =
          s.file.readSome(s.position, {static_cast<std::byte*>(to), static_cast<size_t>(bytes)});
      s.position += got;
      return static_cast<tmsize_t>(got);
    } catch (const std::exception& e) {
      if (s.message.empty()) s.message = e.what();
      return -1;
    }
  }
  static tmsize_t write(thandle_t, void*, tmsize_t) { return -1; }
  static toff_t seek(thandle_t handle, toff_t offset, int whence) {
    Stream& s = of(handle);
    if (whence == SEEK_CUR) offset += s.position;
    if (whence == SEEK_END) offset += s.file.sizeBytes();
    return s.position = offset;
  }
  static int close(thandle_t) { return 0; }
  static toff_t size(thandle_t handle) { return of(handle).file.sizeBytes(); }
  static int error(TIFF*, void* user, const char* module, const char* format, va_list arguments) {
    Stream& s = of(user);
    char text[256];
    std::vsnprintf(text, sizeof text, format, arguments);
    if (s.message.empty()) s.message = fmt::format("{}: {}", module == nullptr ? "" : module, text);
    std::replace(s.message.begin(), s.message.end(), '\n', ' ');
    return 1;  // handled: libtiff's own printing is left out
  }
  static int warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

  File file;
  uint64_t position = 0;
  std::string message;
};

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

// What is stored of one page.
struct Page {
  uint64_t directory = 0;  // where its table lies in the file
  uint32_t width = 0, height = 0;
  uint16_t bits = 1, samples = 1, sample_format = SAMPLEFORMAT_UINT;
  uint16_t photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
  uint16_t planar = PLANARCONFIG_CONTIG, orientation = ORIENTATION_TOPLEFT;
  bool is_tiled = false;

  bool hasColor() const {
    return photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_YCBCR;
  }
  size_t pixelBytes() const { return size_t{samples} * bits / 8; }
};

class TiffPicture final : public SlicePicture {
 public:
  explicit TiffPicture(const std::filesystem::path& path) : stream_(path) {
    TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
    TIFFOpenOptionsSetErrorHandlerExtR(options, Stream::error, &stream_);
    TIFFOpenOptionsSetWarningHandlerExtR(options, Stream::warning, &stream_);
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, kMaxAllocationBytes);
    tiff_.reset(TIFFClientOpenExt(path.c_str(), "rm", &stream_, Stream::read, Stream::write,
                                  Stream::seek, Stream::close, Stream::size, nullptr, nullptr,
                                  options));
    TIFFOpenOptionsFree(options);
    if (!tiff_) failTiff("no readable TIFF");
    listPages();
  }

  const PictureFormat& format() const override { return format_; }
  uint64_t storedBytesRead() const override { return stream_.file.storedBytesRead(); }

  void readRows(int64_t page, int64_t first, int64_t count, std::span<std::byte> out) override {
    const size_t row_bytes = static_cast<size_t>(format_.width) * bytesPerVoxel(format_.type);
    SLUICE_CHECK(page >= 0 && page < format_.pages);
    SLUICE_CHECK(first >= 0 && count >= 0 && first + count <= format_.height);
    SLUICE_CHECK_EQ(out.size(), row_bytes * static_cast<size_t>(count));
    goTo(page);
    const Page& p = pages_[static_cast<size_t>(page)];
    const bool is_upside_down =
        p.orientation == ORIENTATION_BOTLEFT || p.orientation == ORIENTATION_BOTRIGHT;
    const bool is_mirrored =
        p.orientation == ORIENTATION_TOPRIGHT || p.orientation == ORIENTATION_BOTRIGHT;
    if (is_upside_down) first = format_.height - first - count;
    const auto keepRow = [&](int64_t row, const std::byte* stored) {
      const int64_t at = is_upside_down ? first + count - 1 - row : row - first;
      convertRow(p, stored, out.subspan(static_cast<size_t>(at) * row_bytes, row_bytes),
                 is_mirrored);
    };
    if (p.is_tiled) {
      readTiles(p, first, count, keepRow);
    } else if (p.compression == COMPRESSION_NONE) {
      readPlainStrips(p, first, count, keepRow);
    } else {
      readStrips(p, first, count, keepRow);
    }
  }

 private:
  [[noreturn]] void failTiff(const std::string& what) {
    fail("{}: {}{}{}", stream_.file.path(), what, stream_.message.empty() ? "" : ": ",
         std::exchange(stream_.message, {}));
  }

  template <class T>
  T field(uint32_t tag, T otherwise) {
    T value{};
    return TIFFGetFieldDefaulted(tiff_.get(), tag, &value) == 1 ? value : otherwise;
  }

  Page readPage() {
    Page p;
    p.directory = TIFFCurrentDirOffset(tiff_.get());
    p.width = field<uint32_t>(TIFFTAG_IMAGEWIDTH, 0);
    p.height = field<uint32_t>(TIFFTAG_IMAGELENGTH, 0);
    p.bits = field<uint16_t>(TIFFTAG_BITSPERSAMPLE, 1);
    p.samples = field<uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1);
    p.sample_format = field<uint16_t>(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    p.photometric = field<uint16_t>(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    p.compression = field<uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    p.planar = field<uint16_t>(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    p.orientation = field<uint16_t>(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
    p.is_tiled = TIFFIsTiled(tiff_.get()) != 0;
    return p;
  }

  void listPages() {
    do {
      if ((field<uint32_t>(TIFFTAG_SUBFILETYPE, 0) & FILETYPE_REDUCEDIMAGE) != 0) continue;
      const Page p = readPage();
      const PictureFormat format = formatOf(p);
      if (pages_.empty()) {
        format_ = format;
      } else if (format.width != format_.width || format.height != format_.height ||
                 format.type != format_.type) {
        fail("{}: page {} is {} x {} of {}, expected {} x {} of {} as on page 1",
             stream_.file.path(), pages_.size() + 1, format.width, format.height, name(format.type),
             format_.width, format_.height, name(format_.type));
      }
      pages_.push_back(p);
    } while (TIFFReadDirectory(tiff_.get()) != 0);
    if (!stream_.message.empty()) failTiff("damaged TIFF");
    if (pages_.empty()) failTiff("TIFF without a picture of full size");
    format_.pages = static_cast<int64_t>(pages_.size());
    at_page_ = -1;
  }

  PictureFormat formatOf(const Page& p) {
    PictureFormat format;
    format.width = p.width;
    format.height = p.height;
    if (p.width < 1 || p.height < 1 || p.width > PictureFormat::kMaxSide ||
        p.height > PictureFormat::kMaxSide)
      fail("{}: TIFF of {} x {} pixels, expected 1 to {} a side", stream_.file.path(), p.width,
           p.height, PictureFormat::kMaxSide);
    format.type = typeOf(p);
    if (p.orientation > ORIENTATION_BOTLEFT)
      fail("{}: TIFF with transposed rows and columns (orientation {}), expected 1 to 4",
           stream_.file.path(), p.orientation);
    if (p.is_tiled) {
      const uint64_t tile_bytes = TIFFTileSize64(tiff_.get());
      if (tile_bytes == 0 || tile_bytes > kMaxTileBytes)
        fail("{}: TIFF with tiles of {} bytes, expected at most {}", stream_.file.path(),
             tile_bytes, kMaxTileBytes);
      format.unit_rows = field<uint32_t>(TIFFTAG_TILELENGTH, 1);
    }
    return format;
  }

  VoxelType typeOf(const Page& p) {
    const bool is_gray =
        p.photometric == PHOTOMETRIC_MINISBLACK || p.photometric == PHOTOMETRIC_MINISWHITE;
    const bool is_unsigned =
        p.sample_format == SAMPLEFORMAT_UINT || p.sample_format == SAMPLEFORMAT_VOID;
    const bool samples_fit = p.hasColor() ? p.samples >= 3 : p.samples >= 1;
    const bool is_jpeg_color =
        p.photometric == PHOTOMETRIC_YCBCR && p.compression == COMPRESSION_JPEG && p.bits == 8;
    const bool is_side_by_side = p.planar == PLANARCONFIG_CONTIG || p.samples == 1;
    if (samples_fit && p.samples <= 16 && is_side_by_side) {
      if (p.photometric == PHOTOMETRIC_PALETTE && is_unsigned && p.bits == 8) return VoxelType::kU8;
      if (((p.photometric == PHOTOMETRIC_RGB && is_unsigned) || is_jpeg_color) && p.bits == 8)
        return VoxelType::kU8;
      if (p.photometric == PHOTOMETRIC_RGB && is_unsigned && p.bits == 16) return VoxelType::kU16;
      if (is_gray && is_unsigned && p.bits == 8) return VoxelType::kU8;
      if (is_gray && is_unsigned && p.bits == 16) return VoxelType::kU16;
      if (is_gray && is_unsigned && p.bits == 32) return VoxelType::kU32;
      if (is_gray && p.sample_format == SAMPLEFORMAT_INT && p.bits == 8) return VoxelType::kI8;
      if (is_gray && p.sample_format == SAMPLEFORMAT_INT && p.bits == 16) return VoxelType::kI16;
      if (is_gray && p.sample_format == SAMPLEFORMAT_INT && p.bits == 32) return VoxelType::kI32;
      if (is_gray && p.sample_format == SAMPLEFORMAT_IEEEFP && p.bits == 32) return VoxelType::kF32;
      if (is_gray && p.sample_format == SAMPLEFORMAT_IEEEFP && p.bits == 64) return VoxelType::kF64;
    }
    fail(
        "{}: TIFF of {} samples of {} bits (sample format {}, photometric {}, planar {}), expected "
        "grey "
        "of 8, 16 or 32 bit integers or 32 or 64 bit floats, or 8 or 16 bit palette or RGB",
        stream_.file.path(), p.samples, p.bits, p.sample_format, p.photometric, p.planar);
  }

  void goTo(int64_t page) {
    if (page == at_page_) return;
    stream_.message.clear();
    const Page& p = pages_[static_cast<size_t>(page)];
    if (TIFFSetSubDirectory(tiff_.get(), p.directory) == 0) failTiff("damaged TIFF");
    at_page_ = page;
    next_row_ = -1;
    if (p.photometric == PHOTOMETRIC_YCBCR)
      TIFFSetField(tiff_.get(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    if (p.photometric == PHOTOMETRIC_PALETTE) readPalette();
  }

  void readPalette() {
    uint16_t *red = nullptr, *green = nullptr, *blue = nullptr;
    if (TIFFGetField(tiff_.get(), TIFFTAG_COLORMAP, &red, &green, &blue) != 1)
      failTiff("TIFF with a palette that is missing");
    // Old writers put 8 bit numbers where 16 bit ones belong.
    constexpr size_t kEntries = 256;
    uint16_t highest = 0;
    for (size_t i = 0; i < kEntries; ++i) highest = std::max({highest, red[i], green[i], blue[i]});
    palette_.resize(kEntries);
    for (size_t i = 0; i < kEntries; ++i) {
      const uint16_t gray = luminance(red[i], green[i], blue[i]);
      palette_[i] = static_cast<uint8_t>(highest < kEntries ? gray : gray >> 8);
    }
  }

  // Calls keep(row, stored bytes of the row) for each row, top first as stored. Rows of a strip are
  // decoded one after the other, so that a strip as large as the picture needs no memory of its
  // size.
  template <class Keep>
  void readStrips(const Page& p, int64_t first, int64_t count, Keep keep) {
    const tmsize_t scanline = TIFFScanlineSize(tiff_.get());
    if (scanline < static_cast<tmsize_t>(p.width * p.pixelBytes())) failTiff("damaged TIFF");
    buffer_.resize(static_cast<size_t>(scanline));
    const int64_t strip_rows =
        std::clamp<int64_t>(field<uint32_t>(TIFFTAG_ROWSPERSTRIP, p.height), 1, p.height);
    const int64_t strip_start = first / strip_rows * strip_rows;
    const bool can_go_on = next_row_ >= strip_start && next_row_ <= first;
    for (int64_t row = can_go_on ? next_row_ : strip_start; row < first + count; ++row) {
      next_row_ = -1;
      if (TIFFReadScanline(tiff_.get(), buffer_.data(), static_cast<uint32_t>(row), 0) != 1)
        failTiff(fmt::format("page {}, row {}: damaged TIFF", at_page_ + 1, row));
      next_row_ = row + 1;
      if (row >= first) keep(row, buffer_.data());
    }
  }

  // Uncompressed rows lie in the file as they are.
  template <class Keep>
  void readPlainStrips(const Page& p, int64_t first, int64_t count, Keep keep) {
    const size_t row_bytes = p.width * p.pixelBytes();
    buffer_.resize(row_bytes);
    const int64_t strip_rows =
        std::clamp<int64_t>(field<uint32_t>(TIFFTAG_ROWSPERSTRIP, p.height), 1, p.height);
    for (int64_t row = first; row < first + count; ++row) {
      const auto strip = static_cast<uint32_t>(row / strip_rows);
      const auto offset_in_strip = static_cast<uint64_t>(row % strip_rows) * row_bytes;
      const uint64_t strip_at = TIFFGetStrileOffset(tiff_.get(), strip);
      const uint64_t strip_bytes = TIFFGetStrileByteCount(tiff_.get(), strip);
      const uint64_t file_bytes = stream_.file.sizeBytes();
      if (offset_in_strip + row_bytes > strip_bytes || strip_at > file_bytes ||
          offset_in_strip + row_bytes > file_bytes - strip_at)
        fail(
            "{}: TIFF cut short: page {}, row {} needs {} bytes at {} in a strip of {} and a file "
            "of {}",
            stream_.file.path(), at_page_ + 1, row, row_bytes, strip_at + offset_in_strip,
            strip_bytes, file_bytes);
      stream_.file.readAt(strip_at + offset_in_strip, buffer_);
      if (TIFFIsByteSwapped(tiff_.get()) != 0) swapBytes(buffer_, p.bits / 8U);
      keep(row, buffer_.data());
    }
  }

  static void swapBytes(std::span<std::byte> bytes, size_t size) {
    if (size == 1) return;
    for (size_t i = 0; i + size <= bytes.size(); i += size)
      std::reverse(bytes.begin() + static_cast<ptrdiff_t>(i),
                   bytes.begin() + static_cast<ptrdiff_t>(i + size));
  }

  template <class Keep>
  void readTiles(const Page& p, int64_t first, int64_t count, Keep keep) {
    const int64_t tile_width = field<uint32_t>(TIFFTAG_TILEWIDTH, 0);
    const int64_t tile_height = field<uint32_t>(TIFFTAG_TILELENGTH, 0);
    const auto pixel = static_cast<int64_t>(p.pixelBytes());
    if (tile_width < 1 || tile_height < 1 ||
        TIFFTileSize(tiff_.get()) < tile_width * tile_height * pixel)
      failTiff("damaged TIFF");
    buffer_.resize(static_cast<size_t>(TIFFTileSize(tiff_.get())));
    std::vector<std::byte> rows;
    for (int64_t top = first / tile_height * tile_height; top < first + count; top += tile_height) {
      const int64_t begin = std::max(top, first);
      const int64_t end = std::min(top + tile_height, first + count);
      rows.resize(static_cast<size_t>((end - begin) * p.width * pixel));
      for (int64_t left = 0; left < p.width; left += tile_width) {
        if (TIFFReadTile(tiff_.get(), buffer_.data(), static_cast<uint32_t>(left),
                         static_cast<uint32_t>(top), 0, 0) < 0)
          failTiff(fmt::format("page {}, tile at ({}, {}): damaged TIFF", at_page_ + 1, left, top));
        const int64_t columns = std::min<int64_t>(tile_width, p.width - left);
        for (int64_t row = begin; row < end; ++row)
          std::memcpy(rows.data() + ((row - begin) * p.width + left) * pixel,
                      buffer_.data() + (row - top) * tile_width * pixel,
                      static_cast<size_t>(columns * pixel));
      }
      for (int64_t row = begin; row < end; ++row)
        keep(row, rows.data() + (row - begin) * p.width * pixel);
    }
  }

  // A stored row of pixels to a row of scalars.
  void convertRow(const Page& p, const std::byte* stored, std::span<std::byte> out,
                  bool is_mirrored) {
    visitVoxelType(format_.type, [&](auto tag) {
      using T = decltype(tag);
      for (int64_t x = 0; x < p.width; ++x) {
        T sample[3];
        std::memcpy(sample, stored + x * static_cast<int64_t>(p.pixelBytes()),
                    sizeof(T) * (p.hasColor() ? 3 : 1));
        T value = sample[0];
        if constexpr (std::is_same_v<T, uint8_t> || std::is_same_v<T, uint16_t>) {
          if (p.hasColor()) value = luminance(sample[0], sample[1], sample[2]);
          if (p.photometric == PHOTOMETRIC_PALETTE) value = palette_[sample[0]];
        }
        if constexpr (std::is_unsigned_v<T>) {
          if (p.photometric == PHOTOMETRIC_MINISWHITE) value = static_cast<T>(~value);
        }
        const int64_t to = is_mirrored ? p.width - 1 - x : x;
        std::memcpy(out.data() + to * static_cast<int64_t>(sizeof(T)), &value, sizeof(T));
      }
    });
  }

  Stream stream_;
  std::unique_ptr<TIFF, CloseTiff> tiff_;
  PictureFormat format_;
  std::vector<Page> pages_;
  int64_t at_page_ = -1;
  int64_t next_row_ = -1;          // of the page, that the decoder stands at; -1: none
  std::vector<std::byte> buffer_;  // one row or tile as stored
  std::vector<uint8_t> palette_;   // luminance of each entry
};

}  // namespace

std::unique_ptr<SlicePicture> openTiff(const std::filesystem::path& path) {
  return std::make_unique<TiffPicture>(path);
}

}  // namespace sluice

#include "io/slices/tiff/tiff_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "io/files/swap_bytes.h"
#include "src/base/error.h"

namespace sluice {

void TiffRows::begin(int64_t number, const TiffPage& page) {
  number_ = number;
  page_ = page;
  // The decoder and the row belong to the page before.
  next_row_ = -1;
  deflated_.reset();
  fill_.assign(page.bits / 8U, std::byte{0});
  if (!page.no_data) return;
  visitVoxelType(voxelTypeOf(page, stream_.file.path()), [&](auto tag) {
    using T = decltype(tag);
    if constexpr (std::is_integral_v<T>)
      if (!(*page.no_data >= double{std::numeric_limits<T>::min()} &&
            *page.no_data <= double{std::numeric_limits<T>::max()}))
        return;
    tag = static_cast<T>(*page.no_data);
    if (sizeof tag == fill_.size()) std::memcpy(fill_.data(), &tag, sizeof tag);
  });
}

bool TiffRows::isSparse(uint32_t strile) {
  return TIFFGetStrileOffset(tiff_, strile) == 0 && TIFFGetStrileByteCount(tiff_, strile) == 0;
}

void TiffRows::fill(std::span<std::byte> rows) const {
  for (size_t at = 0; at + fill_.size() <= rows.size(); at += fill_.size())
    std::memcpy(rows.data() + at, fill_.data(), fill_.size());
}

void TiffRows::read(int64_t first, int64_t count, const Keep& keep) {
  if (page_.is_tiled) {
    readTiles(first, count, keep);
    return;
  }
  const int64_t strip_rows = rowsPerStrip(), end = first + count;
  const auto isSparseAt = [&](int64_t row) {
    return isSparse(static_cast<uint32_t>(row / strip_rows));
  };
  for (int64_t row = first; row < end;) {
    const bool is_sparse = isSparseAt(row);
    int64_t to = row;
    while (to < end && isSparseAt(to) == is_sparse)
      to = std::min(end, (to / strip_rows + 1) * strip_rows);
    if (!is_sparse) {
      readStoredStrips(row, to - row, keep);
    } else {
      buffer_.resize(page_.width * page_.pixelBytes());
      fill(buffer_);
      for (int64_t i = row; i < to; ++i) keep(i, buffer_.data());
    }
    row = to;
  }
}

void TiffRows::readStoredStrips(int64_t first, int64_t count, const Keep& keep) {
  if (page_.compression == COMPRESSION_NONE) {
    readPlainStrips(first, count, keep);
  } else if (page_.isDeflate()) {
    readDeflateStrips(first, count, keep);
  } else {
    readStrips(first, count, keep);
  }
}

int64_t TiffRows::rowsPerStrip() {
  // TIFF 6, RowsPerStrip: without the tag, all rows are one strip.
  return std::clamp<int64_t>(tiffField<uint32_t>(tiff_, TIFFTAG_ROWSPERSTRIP, page_.height), 1,
                             page_.height);
}

// The decoder of a strip or tile, at its first row. libtiff's names: a strile is either.
std::unique_ptr<DeflateRows> TiffRows::deflateRows(uint32_t strile, size_t row_bytes,
                                                   int64_t rows) {
  const std::string where = fmt::format("{}: page {}, {} {}", stream_.file.path(), number_ + 1,
                                        page_.is_tiled ? "tile" : "strip", strile);
  const uint64_t at = TIFFGetStrileOffset(tiff_, strile);
  const uint64_t bytes = TIFFGetStrileByteCount(tiff_, strile);
  const uint64_t file_bytes = stream_.file.sizeBytes();
  // The count comes from the file and is an allocation below.
  if (at > file_bytes || bytes > file_bytes - at)
    fail("{}: {} bytes at {} in a file of {}; it was cut short", where, bytes, at, file_bytes);
  std::vector<std::byte> stored(bytes);
  stream_.file.readAt(at, stored);
  const DeflateForm form{.row_bytes = row_bytes,
                         .rows = rows,
                         .sample_bytes = page_.bits / 8U,
                         .samples = page_.samples,
                         .predictor = static_cast<TiffPredictor>(page_.predictor),
                         .swapped = TIFFIsByteSwapped(tiff_) != 0};
  return std::make_unique<DeflateRows>(std::move(stored), form, where);
}

// Does what readStrips() does. The checksum of a strip is compared when its last row is read.
void TiffRows::readDeflateStrips(int64_t first, int64_t count, const Keep& keep) {
  const size_t row_bytes = page_.width * page_.pixelBytes();
  buffer_.resize(row_bytes);
  const int64_t strip_rows = rowsPerStrip();
  const int64_t strip_start = first / strip_rows * strip_rows;
  const bool can_go_on = next_row_ >= strip_start && next_row_ <= first;
  for (int64_t row = can_go_on ? next_row_ : strip_start; row < first + count; ++row) {
    // Stands only once the row is decoded: an error below must not leave a decoder to go on with.
    next_row_ = -1;
    if (row % strip_rows == 0)
      deflated_ = deflateRows(static_cast<uint32_t>(row / strip_rows), row_bytes, strip_rows);
    deflated_->next(buffer_);
    if ((row + 1) % strip_rows == 0 || row + 1 == page_.height) deflated_->finish();
    next_row_ = row + 1;
    if (row >= first) keep(row, buffer_.data());
  }
}

// A whole tile into buffer_.
void TiffRows::readDeflateTile(uint32_t tile, size_t row_bytes, int64_t rows) {
  const auto decoder = deflateRows(tile, row_bytes, rows);
  for (int64_t row = 0; row < rows; ++row)
    decoder->next(std::span(buffer_).subspan(static_cast<size_t>(row) * row_bytes, row_bytes));
  decoder->finish();
}

// Calls keep(row, stored bytes of the row) for each row, top first as stored. Rows of a strip are
// decoded one after the other, so that a strip as large as the picture needs no memory of its
// size.
void TiffRows::readStrips(int64_t first, int64_t count, const Keep& keep) {
  const tmsize_t scanline = TIFFScanlineSize(tiff_);
  if (scanline < static_cast<tmsize_t>(page_.width * page_.pixelBytes()))
    stream_.failWith("damaged TIFF");
  buffer_.resize(static_cast<size_t>(scanline));
  const int64_t strip_rows = rowsPerStrip();
  const int64_t strip_start = first / strip_rows * strip_rows;
  const bool can_go_on = next_row_ >= strip_start && next_row_ <= first;
  for (int64_t row = can_go_on ? next_row_ : strip_start; row < first + count; ++row) {
    // See readDeflateStrips().
    next_row_ = -1;
    if (TIFFReadScanline(tiff_, buffer_.data(), static_cast<uint32_t>(row), 0) != 1)
      stream_.failWith(fmt::format("page {}, row {}: damaged TIFF", number_ + 1, row));
    next_row_ = row + 1;
    if (row >= first) keep(row, buffer_.data());
  }
}

// Uncompressed rows lie in the file as they are, usually strip behind strip: contiguous rows
// become one read.
void TiffRows::readPlainStrips(int64_t first, int64_t count, const Keep& keep) {
  const size_t row_bytes = page_.width * page_.pixelBytes();
  const auto most_rows = static_cast<int64_t>(std::max<size_t>(kPlainBytes / row_bytes, 1));
  for (int64_t row = first; row < first + count;) {
    const uint64_t begin = plainRowAt(row, row_bytes);
    int64_t rows = 1;
    while (rows < most_rows && row + rows < first + count &&
           plainRowAt(row + rows, row_bytes) == begin + static_cast<uint64_t>(rows) * row_bytes)
      ++rows;
    buffer_.resize(static_cast<size_t>(rows) * row_bytes);
    stream_.file.readAt(begin, buffer_);
    if (TIFFIsByteSwapped(tiff_) != 0) swapBytes(buffer_, page_.bits / 8U);
    for (int64_t i = 0; i < rows; ++i)
      keep(row + i, buffer_.data() + static_cast<size_t>(i) * row_bytes);
    row += rows;
  }
}

// The offset of a row in the file; throws Error unless the whole row is there.
uint64_t TiffRows::plainRowAt(int64_t row, size_t row_bytes) {
  const int64_t strip_rows = rowsPerStrip();
  const auto strip = static_cast<uint32_t>(row / strip_rows);
  const auto offset_in_strip = static_cast<uint64_t>(row % strip_rows) * row_bytes;
  const uint64_t strip_at = TIFFGetStrileOffset(tiff_, strip);
  const uint64_t strip_bytes = TIFFGetStrileByteCount(tiff_, strip);
  const uint64_t file_bytes = stream_.file.sizeBytes();
  const uint64_t end_in_file = offset_in_strip + row_bytes + page_.moved_bytes;
  if (offset_in_strip + row_bytes > strip_bytes || strip_at > file_bytes ||
      end_in_file > file_bytes - strip_at)
    fail(
        "{}: TIFF cut short: page {}, row {} needs {} bytes at {} in a strip of {} and a file "
        "of {}",
        stream_.file.path(), number_ + 1, row, row_bytes,
        strip_at + offset_in_strip + page_.moved_bytes, strip_bytes, file_bytes);
  return strip_at + offset_in_strip + page_.moved_bytes;
}

void TiffRows::readTiles(int64_t first, int64_t count, const Keep& keep) {
  const int64_t tile_width = tiffField<uint32_t>(tiff_, TIFFTAG_TILEWIDTH, 0);
  const int64_t tile_height = tiffField<uint32_t>(tiff_, TIFFTAG_TILELENGTH, 0);
  const auto pixel = static_cast<int64_t>(page_.pixelBytes());
  // The copies below go by this product, libtiff's buffer by a size of its own.
  if (tile_width < 1 || tile_height < 1 || TIFFTileSize(tiff_) < tile_width * tile_height * pixel)
    stream_.failWith("damaged TIFF");
  buffer_.resize(static_cast<size_t>(TIFFTileSize(tiff_)));
  std::vector<std::byte> rows;
  for (int64_t top = first / tile_height * tile_height; top < first + count; top += tile_height) {
    const int64_t begin = std::max(top, first);
    const int64_t end = std::min(top + tile_height, first + count);
    rows.resize(static_cast<size_t>((end - begin) * page_.width * pixel));
    for (int64_t left = 0; left < page_.width; left += tile_width) {
      const auto x = static_cast<uint32_t>(left), y = static_cast<uint32_t>(top);
      const uint32_t tile = TIFFComputeTile(tiff_, x, y, 0, 0);
      if (isSparse(tile))
        fill(buffer_);
      else if (page_.isDeflate())
        readDeflateTile(tile, static_cast<size_t>(tile_width * pixel), tile_height);
      else if (TIFFReadTile(tiff_, buffer_.data(), x, y, 0, 0) < 0)
        stream_.failWith(
            fmt::format("page {}, tile at ({}, {}): damaged TIFF", number_ + 1, left, top));
      const int64_t columns = std::min<int64_t>(tile_width, page_.width - left);
      for (int64_t row = begin; row < end; ++row)
        std::memcpy(rows.data() + ((row - begin) * page_.width + left) * pixel,
                    buffer_.data() + (row - top) * tile_width * pixel,
                    static_cast<size_t>(columns * pixel));
    }
    for (int64_t row = begin; row < end; ++row)
      keep(row, rows.data() + (row - begin) * page_.width * pixel);
  }
}

}  // namespace sluice

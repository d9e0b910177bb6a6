// TiffRows: the rows of a page of a TIFF as they are stored, whatever holds them: strips or tiles,
// uncompressed or not. Those that are not stored are 0, or the page's GDAL_NODATA: GDAL's sparse
// files give 0 as their place and their size. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "io/slices/deflate_rows.h"
#include "io/slices/tiff/tiff_page.h"
#include "io/slices/tiff/tiff_stream.h"

namespace sluice {

class TiffRows {
 public:
  static constexpr size_t kPlainBytes = size_t{256} << 10;  // uncompressed rows read at once

  // Gets a row and its pixels as stored, in this machine's byte order; they are valid during the
  // call.
  using Keep = std::function<void(int64_t row, const std::byte* stored)>;

  // Both must outlive it.
  TiffRows(TIFF* tiff, TiffStream& stream) : tiff_(tiff), stream_(stream) {}

  // Rows of this page are read from now on, the table of which libtiff stands at. Messages name it
  // by its number, from 0.
  void begin(int64_t number, const TiffPage& page);
  // Gives the rows [first, first + count) to `keep`, top first as stored. Going on where the last
  // call ended costs no row twice. Throws Error if the file is damaged or cut short.
  void read(int64_t first, int64_t count, const Keep& keep);

 private:
  int64_t rowsPerStrip();
  // Whether a strip or tile is not stored: neither a place nor bytes.
  bool isSparse(uint32_t strile);
  void fill(std::span<std::byte> rows) const;
  void readStoredStrips(int64_t first, int64_t count, const Keep& keep);
  std::unique_ptr<DeflateRows> deflateRows(uint32_t strile, size_t row_bytes, int64_t rows);
  void readDeflateStrips(int64_t first, int64_t count, const Keep& keep);
  void readDeflateTile(uint32_t tile, size_t row_bytes, int64_t rows);
  void readStrips(int64_t first, int64_t count, const Keep& keep);
  void readPlainStrips(int64_t first, int64_t count, const Keep& keep);
  uint64_t plainRowAt(int64_t row, size_t row_bytes);
  void readTiles(int64_t first, int64_t count, const Keep& keep);

  TIFF* const tiff_;
  TiffStream& stream_;
  int64_t number_ = -1;
  TiffPage page_;
  int64_t next_row_ = -1;                  // the row at which the decoder stands; -1: none
  std::unique_ptr<DeflateRows> deflated_;  // of a page that isDeflate()
  std::vector<std::byte> buffer_;          // a row or tile as stored
  std::vector<std::byte> fill_;            // a sample of what is not stored
};

}  // namespace sluice

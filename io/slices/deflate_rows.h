// DeflateRows: the rows of one strip or tile of a TIFF that zlib has compressed, one after another.
//
// Rows are decoded here and not by libtiff. libtiff leaves a strip after its last row without
// checking the checksum that follows, so that one flipped bit in twelve changed the picture
// unnoticed. Source of the predictors: TIFF 6.0, section 14, and Adobe's TIFF Technical Note 3. One
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sluice {

enum class TiffPredictor : uint16_t { kNone = 1, kHorizontal = 2, kFloatingPoint = 3 };

struct DeflateForm {
  size_t row_bytes = 0;
  int64_t rows = 0;         // rows of a whole strip or tile; the stream may end after fewer
  size_t sample_bytes = 1;  // 1, 2, 4 or 8
  size_t samples = 1;       // samples of a pixel
  TiffPredictor predictor = TiffPredictor::kNone;
  bool swapped = false;  // the samples are in the other byte order
};

class DeflateRows {
 public:
  // `stored`: the compressed bytes. `where` starts the messages. Throws Error: not enough memory.
  DeflateRows(std::vector<std::byte> stored, const DeflateForm& form, std::string where);
  ~DeflateRows();
  DeflateRows(const DeflateRows&) = delete;
  DeflateRows& operator=(const DeflateRows&) = delete;

  // The next row, its samples in this machine's byte order. Throws Error if the stream is damaged
  // or ends. Requires: out.size() == row_bytes.
  void next(std::span<std::byte> out);
  // To be called after the last row: reads to the end of the stream, which may pad the last strip.
  // Throws Error if the checksum differs, is missing, or the stream goes on beyond all rows.
  void finish();

 private:
  struct Stream;
  // Returns the bytes of `out` that were filled.
  size_t inflateInto(std::span<std::byte> out);

  const std::vector<std::byte> stored_;
  const DeflateForm form_;
  const std::string where_;
  const std::unique_ptr<Stream> stream_;
  bool ended_ = false;  // by the stream's own mark, its checksum found right
  uint64_t done_bytes_ = 0;
  std::vector<std::byte> planes_;  // planes of a row: the floating-point predictor's order
};

}  // namespace sluice

#include "io/slices/deflate_rows.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "io/files/swap_bytes.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// Each sample is stored as the difference from the one of the pixel before.
template <class T>
void accumulate(std::span<std::byte> row, size_t samples) {
  const size_t count = row.size() / sizeof(T);
  const auto at = [&](size_t i) {
    T value;
    std::memcpy(&value, row.data() + i * sizeof(T), sizeof(T));
    return value;
  };
  for (size_t i = samples; i < count; ++i) {
    const T sum = static_cast<T>(at(i) + at(i - samples));
    std::memcpy(row.data() + i * sizeof(T), &sum, sizeof(T));
  }
}

void accumulate(std::span<std::byte> row, size_t sample_bytes, size_t samples) {
  if (sample_bytes == 1) accumulate<uint8_t>(row, samples);
  if (sample_bytes == 2) accumulate<uint16_t>(row, samples);
  if (sample_bytes == 4) accumulate<uint32_t>(row, samples);
  if (sample_bytes == 8) accumulate<uint64_t>(row, samples);
}

// The most significant bytes of all samples come first, then the next ones, whatever the file's
// byte order; each byte is stored as the difference from the one of the pixel before.
void undoFloatingPoint(std::span<std::byte> row, size_t sample_bytes, size_t samples,
                       std::vector<std::byte>& planes) {
  accumulate<uint8_t>(row, samples);
  planes.assign(row.begin(), row.end());
  const size_t count = row.size() / sample_bytes;
  for (size_t i = 0; i < count; ++i)
    for (size_t b = 0; b < sample_bytes; ++b) {
      const size_t plane = std::endian::native == std::endian::big ? b : sample_bytes - 1 - b;
      row[i * sample_bytes + b] = planes[plane * count + i];
    }
}

}  // namespace

struct DeflateRows::Stream {
  z_stream zlib = {};
};

DeflateRows::DeflateRows(std::vector<std::byte> stored, const DeflateForm& form, std::string where)
    : stored_(std::move(stored)),
      form_(form),
      where_(std::move(where)),
      stream_(std::make_unique<Stream>()) {
  // zlib counts its input in 32 bits.
  if (stored_.size() > std::numeric_limits<uInt>::max())
    fail("{}: {} compressed bytes, expected fewer than 4 GiB", where_, stored_.size());
  stream_->zlib.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(stored_.data()));
  stream_->zlib.avail_in = static_cast<uInt>(stored_.size());
  if (inflateInit(&stream_->zlib) != Z_OK) failMemory("{}: not enough memory to decode it", where_);
}

DeflateRows::~DeflateRows() {
  inflateEnd(&stream_->zlib);
}

size_t DeflateRows::inflateInto(std::span<std::byte> out) {
  z_stream& zlib = stream_->zlib;
  zlib.next_out = reinterpret_cast<Bytef*>(out.data());
  zlib.avail_out = static_cast<uInt>(out.size());
  // A stream may end early or late: next() and finish() say which of the two is wrong.
  while (!ended_ && zlib.avail_out > 0) {
    const int status = inflate(&zlib, Z_NO_FLUSH);
    ended_ = status == Z_STREAM_END;
    if (status == Z_BUF_ERROR)
      fail("{}: the compressed stream breaks off before its checksum", where_);
    if (status != Z_OK && !ended_)
      fail("{}: the compressed stream is damaged: {}", where_,
           zlib.msg != nullptr ? zlib.msg : "unknown reason");
  }
  const size_t got = out.size() - zlib.avail_out;
  done_bytes_ += got;
  return got;
}

void DeflateRows::next(std::span<std::byte> out) {
  SLUICE_CHECK_EQ(out.size(), form_.row_bytes);
  const size_t got = inflateInto(out);
  if (got < out.size())
    fail("{}: the compressed stream has {} bytes, expected {} a row and more rows", where_,
         done_bytes_, form_.row_bytes);
  if (form_.predictor == TiffPredictor::kFloatingPoint)
    return undoFloatingPoint(out, form_.sample_bytes, form_.samples, planes_);
  // TIFF 6, section 14: differences are of numbers, so that these need this machine's order first.
  if (form_.swapped) swapBytes(out, form_.sample_bytes);
  if (form_.predictor == TiffPredictor::kHorizontal)
    accumulate(out, form_.sample_bytes, form_.samples);
}

void DeflateRows::finish() {
  const uint64_t most = form_.row_bytes * static_cast<uint64_t>(form_.rows);
  std::array<std::byte, 4096> padding;
  // zlib compares the checksum only at the stream's end, perhaps behind rows that pad a last strip.
  while (!ended_) {
    inflateInto(padding);
    if (done_bytes_ > most)
      fail("{}: the compressed stream goes on beyond its {} rows of {} bytes", where_, form_.rows,
           form_.row_bytes);
  }
}

}  // namespace sluice

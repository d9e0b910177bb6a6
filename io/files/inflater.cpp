#include "io/files/inflater.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {
constexpr size_t kInputBytes = 256 * 1024;
// zlib's numbers for a stream whose header tells which of the two it is, and for one without.
constexpr int kGzipOrZlib = MAX_WBITS + 32, kBare = -MAX_WBITS;
}  // namespace

struct Inflater::State {
  z_stream stream = {};
  std::array<std::byte, kInputBytes> input;
};

Inflater::Inflater(std::shared_ptr<File> file, uint64_t offset)
    : Inflater(std::move(file), offset, std::numeric_limits<uint64_t>::max(), kGzipOrZlib) {}

Inflater::Inflater(std::shared_ptr<File> file, uint64_t offset, uint64_t bytes)
    : Inflater(std::move(file), offset, bytes, kBare) {}

Inflater::Inflater(std::shared_ptr<File> file, uint64_t offset, uint64_t bytes, int window)
    : file_(std::move(file)),
      offset_(offset),
      left_(bytes),
      has_members_(window == kGzipOrZlib),
      state_(std::make_unique_for_overwrite<State>()) {
  if (inflateInit2(&state_->stream, window) != Z_OK)
    failMemory("{}: not enough memory to decode it", file_->path());
}

Inflater::~Inflater() {
  inflateEnd(&state_->stream);
}

// Makes two bytes of input available, or all that is left; false when there is none.
bool Inflater::fillInput() {
  z_stream& stream = state_->stream;
  // Two bytes, since startNextMember() looks for a gzip header's first two.
  if (stream.avail_in >= 2) return true;
  std::byte* const begin = state_->input.data();
  if (stream.avail_in == 1) *begin = static_cast<std::byte>(*stream.next_in);
  const auto room = std::span(state_->input).subspan(stream.avail_in);
  const size_t taken =
      left_ == 0 ? 0 : file_->readSome(offset_, room.first(std::min(left_, room.size())));
  offset_ += taken;
  left_ -= taken;
  stream.next_in = reinterpret_cast<Bytef*>(begin);
  stream.avail_in += static_cast<uInt>(taken);
  return stream.avail_in > 0;
}

void Inflater::startNextMember() {
  z_stream& stream = state_->stream;
  fillInput();
  // A gzip file is a series of members, which are one stream (RFC 1952, 2.2). Other bytes behind
  // them are ignored.
  const bool another = has_members_ && stream.avail_in >= 2 && stream.next_in[0] == 0x1f &&
                       stream.next_in[1] == 0x8b;
  if (another)
    inflateReset(&stream);
  else
    finished_ = true;
}

size_t Inflater::read(std::span<std::byte> out) {
  z_stream& stream = state_->stream;
  size_t got = 0;
  while (got < out.size() && !finished_ && fillInput()) {
    // zlib counts bytes in 32 bits.
    const size_t room = std::min<size_t>(out.size() - got, std::numeric_limits<uInt>::max());
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + got);
    stream.avail_out = static_cast<uInt>(room);
    const int status = inflate(&stream, Z_NO_FLUSH);
    got += room - stream.avail_out;
    if (status == Z_STREAM_END)
      startNextMember();
    else if (status != Z_OK && status != Z_BUF_ERROR)
      fail("{}: the compressed stream is damaged near offset {}: {}", file_->path(),
           offset_ - stream.avail_in, stream.msg != nullptr ? stream.msg : "unknown reason");
  }
  return got;
}

}  // namespace sluice

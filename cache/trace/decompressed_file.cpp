#include "cache/trace/decompressed_file.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/error.h"

namespace sluice::trace_internal {
namespace {

constexpr size_t kBufferBytes = 1 << 16;
constexpr std::string_view kGzipMagic = "\x1f\x8b";
constexpr std::string_view kZstdMagic = "\x28\xb5\x2f\xfd";

// A file and the packed bytes that were read from it and not yet used.
struct PackedInput {
  PackedInput(std::ifstream opened, std::string file_path)
      : file(std::move(opened)), path(std::move(file_path)), bytes(kBufferBytes) {}

  // Reads more bytes when none are left; false at the file's end.
  bool fill() {
    if (at < end) return true;
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (file.bad()) fail("{}: cannot read the trace", path);
    at = 0;
    end = static_cast<size_t>(file.gcount());
    return end > 0;
  }

  std::ifstream file;
  const std::string path;
  std::vector<char> bytes;
  size_t at = 0, end = 0;
};

// Unpacks a block at a time. `kind` is the compression's name for messages.
class Unpacker : public std::streambuf {
 public:
  Unpacker(PackedInput in, std::string_view kind)
      : in_(std::move(in)), kind_(kind), out_(kBufferBytes) {}

 protected:
  // Unpacks into `out` and returns the number of bytes; 0: more input is needed. Sets `ended_` when
  // a member of the file is complete.
  virtual size_t unpack(char* out, size_t room) = 0;

  [[noreturn]] void failDamaged(std::string_view reason) const {
    fail("{}: the {} data is damaged: {}", in_.path, kind_, reason);
  }

  PackedInput in_;
  bool ended_ = false;

 private:
  int_type underflow() override {
    while (in_.fill() || !is_drained_) {
      const size_t got = unpack(out_.data(), out_.size());
      // A full buffer may have more behind it that needs no further input.
      is_drained_ = got < out_.size();
      if (got == 0) continue;
      setg(out_.data(), out_.data(), out_.data() + got);
      return traits_type::to_int_type(out_.front());
    }
    if (!ended_) fail("{}: the {} data ends in the middle; the file may be cut", in_.path, kind_);
    return traits_type::eof();
  }

  const std::string_view kind_;
  std::vector<char> out_;
  bool is_drained_ = true;
};

class GzipUnpacker final : public Unpacker {
 public:
  explicit GzipUnpacker(PackedInput in) : Unpacker(std::move(in), "gzip") {
    constexpr int kGzip = 15 + 16;  // the largest window, gzip headers alone
    if (inflateInit2(&stream_, kGzip) != Z_OK) fail("{}: not enough memory to unpack it", in_.path);
  }
  ~GzipUnpacker() override { inflateEnd(&stream_); }
  GzipUnpacker(const GzipUnpacker&) = delete;
  GzipUnpacker& operator=(const GzipUnpacker&) = delete;

 private:
  size_t unpack(char* out, size_t room) override {
    // Members follow one another and are one stream.
    // The file ends between two members.
    if (in_.at == in_.end && ended_) return 0;
    if (ended_) inflateReset(&stream_);
    ended_ = false;
    stream_.next_in = reinterpret_cast<Bytef*>(in_.bytes.data() + in_.at);
    stream_.avail_in = static_cast<uInt>(in_.end - in_.at);
    stream_.next_out = reinterpret_cast<Bytef*>(out);
    stream_.avail_out = static_cast<uInt>(room);
    const int status = inflate(&stream_, Z_NO_FLUSH);
    in_.at = in_.end - stream_.avail_in;
    if (status == Z_STREAM_END)
      ended_ = true;
    else if (status != Z_OK && status != Z_BUF_ERROR)
      failDamaged(stream_.msg != nullptr ? stream_.msg : "unknown reason");
    return room - stream_.avail_out;
  }

  z_stream stream_ = {};
};

class ZstdUnpacker final : public Unpacker {
 public:
  explicit ZstdUnpacker(PackedInput in)
      : Unpacker(std::move(in), "Zstandard"), stream_(ZSTD_createDStream(), ZSTD_freeDStream) {
    if (!stream_) fail("{}: not enough memory to unpack it", in_.path);
  }

 private:
  size_t unpack(char* out, size_t room) override {
    ZSTD_inBuffer from{in_.bytes.data(), in_.end, in_.at};
    ZSTD_outBuffer to{out, room, 0};
    const size_t status = ZSTD_decompressStream(stream_.get(), &to, &from);
    if (ZSTD_isError(status) != 0) failDamaged(ZSTD_getErrorName(status));
    const bool moved = from.pos != in_.at || to.pos != 0;
    in_.at = from.pos;
    // Without progress, the status belongs to a frame that has not begun.
    // Without progress the status belongs to a frame that has not begun.
    if (moved) ended_ = status == 0;
    return to.pos;
  }

  const std::unique_ptr<ZSTD_DStream, size_t (*)(ZSTD_DStream*)> stream_;
};

// An istream that owns its buffer and passes the buffer's errors on.
class UnpackedStream final : public std::istream {
 public:
  explicit UnpackedStream(std::unique_ptr<Unpacker> buffer)
      : std::istream(buffer.get()), buffer_(std::move(buffer)) {
    exceptions(std::ios::badbit);
  }

 private:
  const std::unique_ptr<Unpacker> buffer_;
};

struct OtherPacking {
  std::string_view magic, name;
};
constexpr std::array kOtherPackings{OtherPacking{{"\xfd"
                                                  "7zXZ",
                                                  5},
                                                 "xz"},
                                    OtherPacking{"BZh", "bzip2"},
                                    OtherPacking{"\x04\x22\x4d\x18", "lz4"},
                                    OtherPacking{"PK\x03\x04", "zip"}};

}  // namespace

std::unique_ptr<std::istream> openUnpacked(const std::filesystem::path& path) {
  auto file = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*file) failErrno(fmt::format("{}: cannot open the trace", path.string()), errno);
  std::array<char, 8> head{};
  file->read(head.data(), head.size());
  const std::string_view start(head.data(), static_cast<size_t>(file->gcount()));
  // A file shorter than the head has set the end's bit.
  file->clear();
  file->seekg(0);
  for (const OtherPacking& other : kOtherPackings)
    if (start.starts_with(other.magic))
      fail("{}: expected a trace, found {} data; unpack it, or pack it with gzip or zstd",
           path.string(), other.name);
  const bool is_gzip = start.starts_with(kGzipMagic);
  if (!is_gzip && !start.starts_with(kZstdMagic)) return file;
  PackedInput in(std::move(*file), path.string());
  std::unique_ptr<Unpacker> unpacker;
  if (is_gzip)
    unpacker = std::make_unique<GzipUnpacker>(std::move(in));
  else
    unpacker = std::make_unique<ZstdUnpacker>(std::move(in));
  return std::make_unique<UnpackedStream>(std::move(unpacker));
}

bool beginsAsZstd(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, kZstdMagic.size()> head{};
  file.read(head.data(), head.size());
  return std::string_view(head.data(), static_cast<size_t>(file.gcount())) == kZstdMagic;
}

std::filesystem::path withoutPackedEnding(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 6> kEndings = {".gz", ".zst", ".zstd",
                                                        ".xz", ".bz2", ".lz4"};
  const std::string ending = path.extension().string();
  const bool is_packed = std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
  return is_packed ? path.parent_path() / path.stem() : path;
}

}  // namespace sluice::trace_internal

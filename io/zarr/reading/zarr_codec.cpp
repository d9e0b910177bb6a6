#include "io/zarr/reading/zarr_codec.h"

#include <blosc.h>
#include <lz4.h>
#include <lzma.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <string_view>

#include "src/base/error.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

// The most that a format can make of a byte: more is claimed only by a damaged file, or to take
// memory. Deflate: 258 bytes for two bits (RFC 1951).
constexpr uint64_t kMostDeflateRatio = 1032;
// A byte of a length stands for 255 bytes.
constexpr uint64_t kMostLz4Ratio = 255;
constexpr uint64_t kMostXzRatio = 8192;
constexpr uint64_t kMostXzMemory = uint64_t{80} << 20;          // its dictionary of up to 64 MiB
constexpr uint64_t kMostZstdRatio = (uint64_t{128} << 10) / 4;  // a block of 4 bytes: one repeated

void checkBlosc(std::span<const std::byte> stored, uint64_t chunk_bytes, const std::string& path) {
  if (stored.size() < BLOSC_MIN_HEADER_LENGTH)
    fail("{}: expected a Blosc chunk, found {} bytes, fewer than its header has", path,
         stored.size());
  size_t decoded = 0, held = 0, block = 0;
  blosc_cbuffer_sizes(stored.data(), &decoded, &held, &block);
  if (decoded != chunk_bytes)
    fail("{}: expected a Blosc chunk of {} bytes, found {}", path, chunk_bytes, decoded);
  if (held != stored.size())
    fail("{}: expected {} bytes of Blosc by its header, found {}; the file was cut or damaged",
         path, held, stored.size());
  if (blosc_cbuffer_validate(stored.data(), stored.size(), &decoded) != 0)
    fail("{}: expected a Blosc chunk, found a damaged header", path);
}

void decodeBlosc(std::span<const std::byte> stored, std::span<std::byte> chunk,
                 const std::string& path) {
  const int got = blosc_decompress_ctx(stored.data(), chunk.data(), chunk.size(), 1);
  if (got >= 0 && static_cast<size_t>(got) == chunk.size()) return;
  const char* inside = blosc_cbuffer_complib(stored.data());
  const std::string_view known = blosc_list_compressors();
  const std::string name = lowercase(inside == nullptr ? "unknown" : inside);
  if (known.find(name) == std::string_view::npos)
    fail("{}: compressed with {} inside Blosc, this machine's Blosc has {}", path, name, known);
  fail("{}: expected {} bytes of Blosc with {} inside, found damaged ones", path, chunk.size(),
       name);
}

// Decodes one or more members, as the gzip format allows.
void decodeDeflate(std::span<const std::byte> stored, std::span<std::byte> chunk,
                   const std::string& path) {
  z_stream stream = {};
  constexpr int kGzipOrZlib = 15 + 32;
  if (inflateInit2(&stream, kGzipOrZlib) != Z_OK)
    failMemory("{}: not enough memory to decode it", path);
  // A chunk and its file are below 2^32 bytes.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(stored.data()));
  stream.avail_in = static_cast<uInt>(stored.size());
  stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
  stream.avail_out = static_cast<uInt>(chunk.size());
  int status = Z_OK;
  uint64_t got = 0;
  for (;;) {
    const uInt before = stream.avail_out;
    status = inflate(&stream, Z_FINISH);
    got += before - stream.avail_out;
    if (status != Z_STREAM_END || stream.avail_in == 0) break;
    inflateReset(&stream);
  }
  inflateEnd(&stream);
  if (status == Z_STREAM_END && got == chunk.size()) return;
  if (status == Z_STREAM_END || (status == Z_BUF_ERROR && got == chunk.size()))
    fail("{}: expected {} bytes once decoded, found {}", path, chunk.size(),
         got == chunk.size() ? "more" : std::to_string(got));
  fail("{}: expected a zlib or gzip stream of {} bytes, found one that is cut or damaged at {}",
       path, chunk.size(), got);
}

void decodeZstd(std::span<const std::byte> stored, std::span<std::byte> chunk,
                const std::string& path) {
  const size_t got = ZSTD_decompress(chunk.data(), chunk.size(), stored.data(), stored.size());
  if (ZSTD_isError(got) != 0)
    fail("{}: expected {} bytes of zstd, found damaged ones: {}", path, chunk.size(),
         ZSTD_getErrorName(got));
  if (got != chunk.size())
    fail("{}: expected {} bytes once decoded, found {}", path, chunk.size(), got);
}

void decodeLz4(std::span<const std::byte> stored, std::span<std::byte> chunk,
               const std::string& path) {
  const int got = LZ4_decompress_safe(
      reinterpret_cast<const char*>(stored.data()), reinterpret_cast<char*>(chunk.data()),
      static_cast<int>(stored.size()), static_cast<int>(chunk.size()));
  if (got < 0 || static_cast<size_t>(got) != chunk.size())
    fail("{}: expected {} bytes of LZ4, found damaged ones", path, chunk.size());
}

void decodeXz(std::span<const std::byte> stored, std::span<std::byte> chunk,
              const std::string& path) {
  uint64_t memory = kMostXzMemory;
  size_t in = 0, out = 0;
  const lzma_ret status = lzma_stream_buffer_decode(
      &memory, 0, nullptr, reinterpret_cast<const uint8_t*>(stored.data()), &in, stored.size(),
      reinterpret_cast<uint8_t*>(chunk.data()), &out, chunk.size());
  if (status == LZMA_MEMLIMIT_ERROR)
    fail("{}: expected xz that needs at most {} bytes to decode, found one of {}", path,
         kMostXzMemory, memory);
  if (status != LZMA_OK || in != stored.size() || out != chunk.size())
    fail("{}: expected {} bytes of xz, found damaged ones", path, chunk.size());
}

void requireRatio(const char* name, uint64_t most, std::span<const std::byte> stored,
                  uint64_t chunk_bytes, const std::string& path) {
  if (stored.size() < chunk_bytes / most)
    fail("{}: expected {} of {} bytes, found {}, which cannot hold them", path, name, chunk_bytes,
         stored.size());
}

}  // namespace

void checkStoredSize(ZarrCodec codec, uint64_t stored_bytes, uint64_t chunk_bytes,
                     const std::string& path) {
  if (codec == ZarrCodec::kNone && stored_bytes != chunk_bytes)
    fail("{}: expected {} bytes, found {}", path, chunk_bytes, stored_bytes);
  constexpr uint64_t kHeaders = 4096;
  const uint64_t most = chunk_bytes + chunk_bytes / 16 + kHeaders;
  if (stored_bytes > most)
    fail("{}: expected at most {} bytes for a chunk of {}, found {}", path, most, chunk_bytes,
         stored_bytes);
}

void checkStored(ZarrCodec codec, std::span<const std::byte> stored, uint64_t chunk_bytes,
                 const std::string& path) {
  switch (codec) {
    case ZarrCodec::kNone:
      return;
    case ZarrCodec::kBlosc:
      return checkBlosc(stored, chunk_bytes, path);
    case ZarrCodec::kDeflate:
      return requireRatio("zlib or gzip", kMostDeflateRatio, stored, chunk_bytes, path);
    case ZarrCodec::kLz4:
      return requireRatio("LZ4", kMostLz4Ratio, stored, chunk_bytes, path);
    case ZarrCodec::kXz:
      return requireRatio("xz", kMostXzRatio, stored, chunk_bytes, path);
    case ZarrCodec::kZstd: {
      const unsigned long long said = ZSTD_getFrameContentSize(stored.data(), stored.size());
      if (said == ZSTD_CONTENTSIZE_ERROR)
        fail("{}: expected a zstd frame, found none in {} bytes", path, stored.size());
      if (said != ZSTD_CONTENTSIZE_UNKNOWN && said > chunk_bytes)
        fail("{}: expected {} bytes of zstd, found {}", path, chunk_bytes, said);
      return requireRatio("zstd", kMostZstdRatio, stored, chunk_bytes, path);
    }
  }
}

void decodeChunk(ZarrCodec codec, std::span<const std::byte> stored, std::span<std::byte> chunk,
                 const std::string& path) {
  switch (codec) {
    case ZarrCodec::kNone:
      SLUICE_CHECK_EQ(stored.size(), chunk.size());
      std::memcpy(chunk.data(), stored.data(), chunk.size());
      return;
    case ZarrCodec::kBlosc:
      return decodeBlosc(stored, chunk, path);
    case ZarrCodec::kDeflate:
      return decodeDeflate(stored, chunk, path);
    case ZarrCodec::kZstd:
      return decodeZstd(stored, chunk, path);
    case ZarrCodec::kLz4:
      return decodeLz4(stored, chunk, path);
    case ZarrCodec::kXz:
      return decodeXz(stored, chunk, path);
  }
}

int bloscShuffle(size_t voxel_bytes, const BloscOptions& options) {
  if (voxel_bytes > 1) return BLOSC_SHUFFLE;
  return options.shuffles_bits ? BLOSC_BITSHUFFLE : BLOSC_NOSHUFFLE;
}

uint64_t bloscRoomBytes(uint64_t chunk_bytes) {
  return chunk_bytes + BLOSC_MAX_OVERHEAD;
}

std::span<const std::byte> encodeBlosc(std::span<const std::byte> chunk, size_t voxel_bytes,
                                       const BloscOptions& options, std::vector<std::byte>& room) {
  room.resize(bloscRoomBytes(chunk.size()));
  const char* inside = options.codec == BloscCodec::kLz4 ? BLOSC_LZ4_COMPNAME : BLOSC_ZSTD_COMPNAME;
  const int got = blosc_compress_ctx(options.level, bloscShuffle(voxel_bytes, options), voxel_bytes,
                                     chunk.size(), chunk.data(), room.data(), room.size(), inside,
                                     kBloscBlockBytes, 1);
  SLUICE_CHECK_LT(0, got);
  return std::span(room).first(static_cast<size_t>(got));
}

}  // namespace sluice

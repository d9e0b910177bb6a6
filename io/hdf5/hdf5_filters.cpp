#include "io/hdf5/hdf5_filters.h"

#include <algorithm>
#include <cstring>

#include "io/zarr/reading/zarr_codec.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr int kDeflate = 1, kShuffle = 2, kFletcher = 3, kLzf = 32000, kBlosc = 32001, kLz4 = 32004,
              kZstd = 32015;
constexpr size_t kFletcherBytes = 4;

// Adler's cousin over big-endian words of 16 bits, as HDF5 computes it.
uint32_t fletcher32(std::span<const std::byte> bytes) {
  uint64_t a = 0, b = 0;
  for (size_t i = 0; i + 1 < bytes.size(); i += 2) {
    a = (a + (static_cast<uint64_t>(bytes[i]) << 8 | static_cast<uint64_t>(bytes[i + 1]))) % 65535;
    b = (b + a) % 65535;
  }
  if (bytes.size() % 2 == 1) {
    a = (a + (static_cast<uint64_t>(bytes.back()) << 8)) % 65535;
    b = (b + a) % 65535;
  }
  return static_cast<uint32_t>(b << 16 | a);
}

// Sums of 0 and of 65535 are the same.
bool isSameSum(uint32_t a, uint32_t b) {
  return (a & 0xffff) % 65535 == (b & 0xffff) % 65535 && (a >> 16) % 65535 == (b >> 16) % 65535;
}

void checkFletcher(std::vector<std::byte>& bytes, const std::string& path) {
  if (bytes.size() < kFletcherBytes)
    fail("{}: expected a chunk with a checksum, found {} bytes", path, bytes.size());
  uint32_t stored = 0;
  std::memcpy(&stored, bytes.data() + bytes.size() - kFletcherBytes, kFletcherBytes);
  bytes.resize(bytes.size() - kFletcherBytes);
  const uint32_t found = fletcher32(bytes);
  // Old versions wrote the two bytes of each half in the other order.
  const uint32_t turned = (stored & 0x00ff00ff) << 8 | (stored & 0xff00ff00) >> 8;
  if (!isSameSum(found, stored) && !isSameSum(found, turned))
    fail("{}: expected the checksum {:08x}, as stored, found {:08x}; a chunk is damaged", path,
         stored, found);
}

void unshuffle(std::span<const std::byte> from, std::span<std::byte> to, size_t width) {
  // Bytes that fill no whole value stay at the end, as HDF5's shuffle leaves them.
  const size_t count = from.size() / width, whole = count * width;
  for (size_t byte = 0; byte < width; ++byte) {
    const std::byte* const plane = from.data() + byte * count;
    for (size_t i = 0; i < count; ++i) to[i * width + byte] = plane[i];
  }
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(whole), from.end(),
            to.begin() + static_cast<std::ptrdiff_t>(whole));
}

// LibLZF's format: runs of literal bytes, and copies of what was decoded before.
bool decodeLzf(std::span<const std::byte> from, std::span<std::byte> to) {
  size_t in = 0, out = 0;
  while (in < from.size()) {
    const auto control = static_cast<size_t>(from[in++]);
    if (control < 32) {
      const size_t count = control + 1;
      if (count > from.size() - in || count > to.size() - out) return false;
      std::memcpy(to.data() + out, from.data() + in, count);
      in += count;
      out += count;
      continue;
    }
    size_t count = control >> 5;
    if (count == 7) {
      if (in == from.size()) return false;
      count += static_cast<size_t>(from[in++]);
    }
    if (in == from.size()) return false;
    const size_t back = ((control & 31) << 8) + static_cast<size_t>(from[in++]) + 1;
    count += 2;
    if (back > out || count > to.size() - out) return false;
    for (size_t i = 0; i < count; ++i, ++out) to[out] = to[out - back];  // they may overlap
  }
  return out == to.size();
}

uint64_t bigEndian(std::span<const std::byte> bytes) {
  uint64_t value = 0;
  for (const std::byte byte : bytes) value = value << 8 | static_cast<uint64_t>(byte);
  return value;
}

// The size of all, that of a block, and each block behind its size.
void decodeLz4Blocks(std::span<const std::byte> from, std::span<std::byte> to,
                     const std::string& path) {
  constexpr size_t kFront = 12, kSize = 4;
  const auto failCut = [&] {
    fail("{}: expected {} bytes of LZ4, found a cut chunk", path, to.size());
  };
  if (from.size() < kFront) failCut();
  if (bigEndian(from.first(8)) != to.size())
    fail("{}: expected {} bytes of LZ4, found {}", path, to.size(), bigEndian(from.first(8)));
  const uint64_t block = bigEndian(from.subspan(8, 4));
  from = from.subspan(kFront);
  while (!to.empty()) {
    if (from.size() < kSize || block == 0) failCut();
    const uint64_t stored = bigEndian(from.first(kSize));
    from = from.subspan(kSize);
    if (stored > from.size()) failCut();
    const auto out = to.first(std::min<uint64_t>(block, to.size()));
    // A block that did not shrink is stored as it is.
    const ZarrCodec codec = stored == out.size() ? ZarrCodec::kNone : ZarrCodec::kLz4;
    decodeChunk(codec, from.first(stored), out, path);
    from = from.subspan(stored);
    to = to.subspan(out.size());
  }
}

void decodeBy(const Hdf5Filter& filter, std::span<const std::byte> from, std::span<std::byte> to,
              const std::string& path) {
  const auto byCodec = [&](ZarrCodec codec) {
    checkStoredSize(codec, from.size(), to.size(), path);
    checkStored(codec, from, to.size(), path);
    decodeChunk(codec, from, to, path);
  };
  switch (filter.number) {
    case kDeflate:
      return byCodec(ZarrCodec::kDeflate);
    case kBlosc:
      return byCodec(ZarrCodec::kBlosc);
    case kZstd:
      return byCodec(ZarrCodec::kZstd);
    case kLz4:
      return decodeLz4Blocks(from, to, path);
    case kShuffle: {
      const size_t width = filter.values.empty() ? 1 : filter.values[0];
      if (from.size() != to.size() || width == 0)
        fail("{}: expected {} shuffled bytes, found {}", path, to.size(), from.size());
      return unshuffle(from, to, width);
    }
    default:
      if (!decodeLzf(from, to))
        fail("{}: expected {} bytes of LZF, found damaged ones", path, to.size());
  }
}

}  // namespace

bool areKnownFilters(std::span<const Hdf5Filter> filters) {
  int compressors = 0;
  for (const Hdf5Filter& filter : filters) {
    if (filter.number == kShuffle || filter.number == kFletcher) continue;
    const int known[] = {kDeflate, kLzf, kBlosc, kLz4, kZstd};
    if (std::find(std::begin(known), std::end(known), filter.number) == std::end(known))
      return false;
    ++compressors;
  }
  return compressors <= 1;
}

void undoFilters(std::span<const Hdf5Filter> filters, uint32_t mask, std::vector<std::byte>& stored,
                 std::span<std::byte> chunk, const std::string& path) {
  // A bit of a chunk's filter mask says that its filter was left out (HDF5 file format).
  const auto isApplied = [mask](size_t i) { return i >= 32 || (mask >> i & 1) == 0; };
  std::vector<std::byte> decoded;
  // Filters are undone in the reverse of the order in which they were applied.
  for (size_t i = filters.size(); i-- > 0;) {
    if (!isApplied(i)) continue;
    if (filters[i].number == kFletcher) {
      checkFletcher(stored, path);
      continue;
    }
    // The checksums that were appended before it are among its bytes.
    size_t bytes = chunk.size();
    for (size_t before = 0; before < i; ++before)
      if (isApplied(before) && filters[before].number == kFletcher) bytes += kFletcherBytes;
    decoded.resize(bytes);
    decodeBy(filters[i], stored, decoded, path);
    std::swap(stored, decoded);
  }
  if (stored.size() != chunk.size())
    fail("{}: expected a chunk of {} bytes, found {}", path, chunk.size(), stored.size());
  std::copy(stored.begin(), stored.end(), chunk.begin());
}

}  // namespace sluice

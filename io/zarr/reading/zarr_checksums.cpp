#include "io/zarr/reading/zarr_checksums.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <cstring>

#include "src/base/error.h"
#include "src/base/files/atomic_file.h"

namespace sluice {
namespace {

// In this machine's byte order: another machine finds the magic reversed, and reports it.
struct Header {
  std::array<char, 8> magic = {'S', 'L', 'U', 'I', 'C', 'E', 'Z', '1'};
  uint64_t order = 0x0102030405060708;
  uint64_t chunk_count = 0;
  uint64_t array_checksum = 0;   // XXH3 of the .zarray
  uint64_t chunks_checksum = 0;  // XXH3 of the bytes after the header
  uint64_t header_checksum = 0;  // XXH3 of the header with 0 here
};
static_assert(sizeof(Header) == 48, "no padding, whose bytes would be unchecked");
static_assert(sizeof(Header) % sizeof(StoredChunk) == 0, "read into a row of these");

uint64_t ownChecksum(Header header) {
  header.header_checksum = 0;
  return zarrChecksum(std::as_bytes(std::span(&header, 1)));
}

constexpr const char* kRemedy = "pack the volume again, or remove the file to read unchecked";

}  // namespace

uint64_t zarrChecksum(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::optional<std::vector<StoredChunk>> readZarrChecksums(const StorePlace& folder,
                                                          std::string_view array_text,
                                                          int64_t chunk_count) {
  const StorePlace place = folder.at(std::string(kZarrChecksumsName));
  const std::string path = place.name();
  std::vector<StoredChunk> chunks;  // the header in the first of them at first
  // Before room is made: the file must be as long as the array's chunks need.
  const uint64_t expected =
      sizeof(Header) + static_cast<uint64_t>(chunk_count) * sizeof(StoredChunk);
  const bool is_there = place.store->read(place.key, {}, [&](const PieceInfo& piece) {
    if (piece.bytes < sizeof(Header)) fail("{}: cut short; {}", path, kRemedy);
    if (piece.bytes != expected)
      fail("{}: expected {} bytes, found {}; {}", path, expected, piece.bytes, kRemedy);
    chunks.resize(piece.bytes / sizeof(StoredChunk));
    return std::as_writable_bytes(std::span(chunks));
  });
  if (!is_there) return std::nullopt;
  Header header;
  const Header ours;
  std::memcpy(static_cast<void*>(&header), chunks.data(), sizeof header);
  chunks.erase(chunks.begin(), chunks.begin() + sizeof(Header) / sizeof(StoredChunk));
  if (header.magic != ours.magic || header.order != ours.order)
    fail("{}: no checksums of this version of sluice and kind of machine; {}", path, kRemedy);
  if (header.header_checksum != ownChecksum(header))
    fail("{}: damaged in its header; {}", path, kRemedy);
  // The checksums hold for one layout of chunks, which the metadata beside them tells.
  if (header.array_checksum != zarrChecksum(std::as_bytes(std::span(array_text))) ||
      header.chunk_count != static_cast<uint64_t>(chunk_count))
    fail("{}: of another .zarray than the one beside it, which was damaged or changed; {}", path,
         kRemedy);
  if (zarrChecksum(std::as_bytes(std::span(chunks))) != header.chunks_checksum)
    fail("{}: damaged; {}", path, kRemedy);
  return chunks;
}

uint64_t zarrChecksumsBytes(std::span<const StoredChunk> chunks) {
  return sizeof(Header) + chunks.size_bytes();
}

void writeZarrChecksums(const std::filesystem::path& folder, std::string_view array_text,
                        std::span<const StoredChunk> chunks) {
  Header header;
  header.chunk_count = chunks.size();
  header.array_checksum = zarrChecksum(std::as_bytes(std::span(array_text)));
  header.chunks_checksum = zarrChecksum(std::as_bytes(chunks));
  header.header_checksum = ownChecksum(header);
  AtomicFile file(folder / kZarrChecksumsName);
  file.write(std::as_bytes(std::span(&header, 1)));
  file.write(std::as_bytes(chunks));
  file.commit();
}

}  // namespace sluice

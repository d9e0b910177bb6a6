#include "io/zarr/zarr_checksums.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>

#include "io/files/file.h"
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

uint64_t ownChecksum(Header header) {
  header.header_checksum = 0;
  return zarrChecksum(std::as_bytes(std::span(&header, 1)));
}

constexpr const char* kRemedy = "pack the volume again, or remove the file to read unchecked";

}  // namespace

uint64_t zarrChecksum(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::optional<std::vector<StoredChunk>> readZarrChecksums(const std::filesystem::path& folder,
                                                          std::string_view array_text,
                                                          int64_t chunk_count) {
  const std::filesystem::path path = folder / kZarrChecksumsName;
  std::error_code status;
  if (std::filesystem::symlink_status(path, status).type() == std::filesystem::file_type::not_found)
    return std::nullopt;
  File file(path);
  Header header;
  const Header ours;
  if (file.sizeBytes() < sizeof header) fail("{}: cut short; {}", path.string(), kRemedy);
  file.readAt(0, std::as_writable_bytes(std::span(&header, 1)));
  if (header.magic != ours.magic || header.order != ours.order)
    fail("{}: no checksums of this version of sluice and kind of machine; {}", path.string(),
         kRemedy);
  if (header.header_checksum != ownChecksum(header))
    fail("{}: damaged in its header; {}", path.string(), kRemedy);
  if (header.array_checksum != zarrChecksum(std::as_bytes(std::span(array_text))) ||
      header.chunk_count != static_cast<uint64_t>(chunk_count))
    fail("{}: of another .zarray than the one beside it, which was damaged or changed; {}",
         path.string(), kRemedy);
  // Before room is made: the file must be as long as its header declares.
  if ((file.sizeBytes() - sizeof header) / sizeof(StoredChunk) != header.chunk_count ||
      (file.sizeBytes() - sizeof header) % sizeof(StoredChunk) != 0)
    fail("{}: expected {} bytes, found {}; {}", path.string(),
         sizeof header + header.chunk_count * sizeof(StoredChunk), file.sizeBytes(), kRemedy);
  std::vector<StoredChunk> chunks(header.chunk_count);
  file.readAt(sizeof header, std::as_writable_bytes(std::span(chunks)));
  if (zarrChecksum(std::as_bytes(std::span(chunks))) != header.chunks_checksum)
    fail("{}: damaged; {}", path.string(), kRemedy);
  return chunks;
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

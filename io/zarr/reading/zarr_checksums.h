// The checksums that `sluice pack` keeps in an array's folder, in ".sluice-checksums": for each
// chunk the length and the XXH3 of its file. With them a flipped bit, a cut or a missing chunk is
// an Error and never a wrong picture; without them (a store of another program) a missing chunk is
// the fill value, as Zarr has it. Other programs pass the file over.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "io/stores/chunk_store.h"

namespace sluice {

inline constexpr std::string_view kZarrChecksumsName = ".sluice-checksums";

struct StoredChunk {
  uint64_t bytes = 0;  // size of the file; 0: no file, the chunk is all fill value
  uint64_t checksum = 0;
};
static_assert(sizeof(StoredChunk) == 16, "as it lies in the file");

// XXH3 of 64 bits over the bytes as they are stored.
uint64_t zarrChecksum(std::span<const std::byte> bytes);

// The chunks by number. `array_text` is the .zarray that the chunks belong to. nullopt when the
// folder has no such file. Throws Error when it is damaged or of another array, or cannot be read.
std::optional<std::vector<StoredChunk>> readZarrChecksums(const StorePlace& folder,
                                                          std::string_view array_text,
                                                          int64_t chunk_count);

// The size of their file.
uint64_t zarrChecksumsBytes(std::span<const StoredChunk> chunks);

// Throws Error. The file appears whole or not at all.
void writeZarrChecksums(const std::filesystem::path& folder, std::string_view array_text,
                        std::span<const StoredChunk> chunks);

}  // namespace sluice

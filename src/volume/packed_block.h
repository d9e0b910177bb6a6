// Compression of a block's voxels in memory: how level 2 keeps cold blocks (Tong 1999, section 5
// names compression as a way to keep more of a volume in memory). Blosc with LZ4, bytes of a voxel
// shuffled apart: of the codecs that `sluice bench packing` compares it gives the most bytes back a
// second. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>

namespace sluice {

struct PackedBytes {
  // Memory from malloc, because realloc can cut off the excess without a copy.
  struct Free {
    void operator()(std::byte* memory) const { std::free(memory); }
  };
  size_t byte_count = 0;
  std::unique_ptr<std::byte[], Free> bytes;
};

struct PackCodec {
  const char* name = "lz4";  // one of Blosc's compressors
  int level = 5;             // 1 to 9
};

// Nullopt if packing does not save an eighth: noise is better dropped and read again. Throws
// std::bad_alloc. For a while it takes in addition to the voxels, its result among them: room for
// seven eighths of them, and two of Blosc's blocks of 128 Ki voxels, which unpack() takes too.
std::optional<PackedBytes> pack(std::span<const std::byte> voxels, size_t voxel_bytes,
                                PackCodec codec = {});
// Requires: `packed` was made by pack() from out.size() bytes. Throws std::bad_alloc.
void unpack(const PackedBytes& packed, std::span<std::byte> out);

}  // namespace sluice

// Compression of a block's voxels in memory: how level 2 keeps cold blocks (Tong 1999, section 5
// names compression as what would let more of a volume stay in memory). Blosc with LZ4, bytes of a
// voxel shuffled apart: of the codecs that `sluice bench packing` compares it gives the most bytes
// back a second. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

namespace sluice {

struct PackedBytes {
  size_t byte_count = 0;
  std::unique_ptr<std::byte[]> bytes;
};

struct PackCodec {
  const char* name = "lz4";  // of Blosc's compressors
  int level = 5;             // 1 to 9
};

// Nullopt where packing does not save an eighth: noise is better dropped and read again. Takes as
// much memory again as `voxels` while it works.
std::optional<PackedBytes> pack(std::span<const std::byte> voxels, size_t voxel_bytes,
                                PackCodec codec = {});
// Requires: `packed` was made by pack() from out.size() bytes.
void unpack(const PackedBytes& packed, std::span<std::byte> out);

}  // namespace sluice

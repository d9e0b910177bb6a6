#include "src/volume/packed_block.h"

#include <blosc.h>

#include <cstring>

#include "src/base/error.h"

namespace sluice {

std::optional<PackedBytes> pack(std::span<const std::byte> voxels, size_t voxel_bytes,
                                PackCodec codec) {
  const size_t most = voxels.size() - voxels.size() / 8;
  const auto scratch = std::make_unique_for_overwrite<std::byte[]>(most + BLOSC_MAX_OVERHEAD);
  const int shuffle = voxel_bytes > 1 ? BLOSC_SHUFFLE : BLOSC_NOSHUFFLE;
  const int packed = blosc_compress_ctx(codec.level, shuffle, voxel_bytes, voxels.size(),
                                        voxels.data(), scratch.get(), most, codec.name, 0, 1);
  if (packed <= 0) return std::nullopt;  // larger than `most`
  PackedBytes result{static_cast<size_t>(packed), nullptr};
  result.bytes = std::make_unique_for_overwrite<std::byte[]>(result.byte_count);
  std::memcpy(result.bytes.get(), scratch.get(), result.byte_count);
  return result;
}

void unpack(const PackedBytes& packed, std::span<std::byte> out) {
  const int bytes = blosc_decompress_ctx(packed.bytes.get(), out.data(), out.size(), 1);
  SLUICE_CHECK_EQ(bytes, static_cast<int>(out.size()));
}

}  // namespace sluice

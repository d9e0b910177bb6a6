#include "src/volume/packed_block.h"

#include <blosc.h>

#include <new>

#include "src/base/error.h"

namespace sluice {
namespace {

// The most bytes at which packing still pays.
size_t mostPackedBytes(size_t byte_count) {
  return byte_count - byte_count / 8;
}

}  // namespace

std::optional<PackedBytes> pack(std::span<const std::byte> voxels, size_t voxel_bytes,
                                PackCodec codec) {
  const size_t most = mostPackedBytes(voxels.size());
  PackedBytes result;
  result.bytes.reset(static_cast<std::byte*>(std::malloc(most + BLOSC_MAX_OVERHEAD)));
  if (result.bytes == nullptr) throw std::bad_alloc();
  // Shuffling apart the bytes of a voxel helps only if there are several.
  const int shuffle = voxel_bytes > 1 ? BLOSC_SHUFFLE : BLOSC_NOSHUFFLE;
  const int packed = blosc_compress_ctx(codec.level, shuffle, voxel_bytes, voxels.size(),
                                        voxels.data(), result.bytes.get(), most, codec.name, 0, 1);
  if (packed <= 0) return std::nullopt;  // larger than `most`
  result.byte_count = static_cast<size_t>(packed);
  void* const shorter = std::realloc(result.bytes.get(), result.byte_count);
  if (shorter != nullptr) {
    static_cast<void>(result.bytes.release());
    result.bytes.reset(static_cast<std::byte*>(shorter));
  }
  return result;
}

void unpack(const PackedBytes& packed, std::span<std::byte> out) {
  const int bytes = blosc_decompress_ctx(packed.bytes.get(), out.data(), out.size(), 1);
  if (bytes < 0) throw std::bad_alloc();  // the bytes are ours: nothing else can be missing
  SLUICE_CHECK_EQ(bytes, static_cast<int>(out.size()));
}

}  // namespace sluice

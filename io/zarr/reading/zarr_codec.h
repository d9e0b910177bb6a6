// The codecs of Zarr chunks: bytes to bytes, bounded by the chunk size in the array's header. Any
// number of threads may call at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"

namespace sluice {

// Throws Error, which starts with `path`, unless a file of `stored_bytes` can hold a chunk of
// `chunk_bytes`: no codec makes data much larger. Called before anything is read or allocated.
void checkStoredSize(ZarrCodec codec, uint64_t stored_bytes, uint64_t chunk_bytes,
                     const std::string& path);

// Throws Error, which starts with `path`, if the file's own header shows that it is not a chunk of
// `chunk_bytes`. Called with the whole file, before room for the chunk is made, so that a lie in
// either header costs nothing.
void checkStored(ZarrCodec codec, std::span<const std::byte> stored, uint64_t chunk_bytes,
                 const std::string& path);

// Fills `chunk`. Throws Error, which starts with `path`: damaged, of another size, a codec inside
// Blosc that this machine's library does not have. Requires: checkStored.
void decodeChunk(ZarrCodec codec, std::span<const std::byte> stored, std::span<std::byte> chunk,
                 const std::string& path);

// Blosc as it is written: the codec inside and how hard it tries.
enum class BloscCodec { kLz4, kZstd };
struct BloscOptions {
  BloscCodec codec = BloscCodec::kLz4;
  int level = 5;  // 1 to 9
  // Shuffles the bits of one-byte voxels: noisy ones take less storage then, and all take two to
  // three times as long to decode.
  bool shuffles_bits = true;
};
// The block size for Blosc, in bytes. Blosc's own choice grows with the level and saves nothing on
// disk, but then each decoding maps memory anew.
constexpr int kBloscBlockBytes = 32 << 10;
// The shuffle as numcodecs numbers it in .zarray: by bytes, by bits or none for voxels of one byte.
int bloscShuffle(size_t voxel_bytes, const BloscOptions& options);
// The bytes of the chunk's file, in `room`, which is made as large as it may have to be. The same
// for the same arguments and library. Requires: chunk not empty, at most kMostChunkBytes.
std::span<const std::byte> encodeBlosc(std::span<const std::byte> chunk, size_t voxel_bytes,
                                       const BloscOptions& options, std::vector<std::byte>& room);
// The size that `room` reaches.
uint64_t bloscRoomBytes(uint64_t chunk_bytes);

}  // namespace sluice

// ZarrArray: the contents of the .zarray of a Zarr v2 array, or of the zarr.json of a v3 one,
// checked: shape, chunks, type, codecs, fill.
//
// A Zarr array is a folder of files, all for parts of one shape, those at the upper ends padded. A
// file is one chunk, or a shard: many chunks, which an index in the file places. A chunk that
// equals the fill value throughout need not exist. Plain values; nothing here touches a file, so
// that the parsers can be fuzzed. Sources: the Zarr storage specification, version 2; the Zarr core
// specification, version 3, and its codecs bytes, transpose, gzip, zstd, blosc, crc32c and
// sharding_indexed.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/values/voxel_type.h"

namespace sluice {

// kDeflate: zlib or gzip; kLz4: one block of LZ4; kXz: the .xz format. Zarr has neither of these
// two.
enum class ZarrCodec { kNone, kBlosc, kDeflate, kZstd, kLz4, kXz };

// The index of a shard: offset and size of each of its chunks, 8 bytes each, the last axis fastest.
struct ZarrShardIndex {
  bool is_first = false;  // at the start of the file, not at its end
  bool has_crc = false;   // a CRC32C follows it
  std::endian byte_order = std::endian::little;
};

struct ZarrArray {
  // In the order of the metadata. `chunks`: what is decoded at once. `files`: what one file holds,
  // whole chunks; without shards one chunk.
  std::vector<int64_t> shape, chunks, files;
  std::vector<size_t> order;  // axes inside a chunk, from the slowest to the fastest
  VoxelType type = VoxelType::kU8;
  std::endian byte_order = std::endian::little;
  ZarrCodec codec = ZarrCodec::kNone;
  bool has_crc = false;  // a CRC32C follows the stored bytes of each chunk
  std::optional<ZarrShardIndex> shards;
  double fill_value = 0;  // value of missing chunks, of `type`
  char separator = '.';   // between the numbers of a file's name
  std::string prefix;     // before them, with a separator
  // N5: the numbers of a file's name are in the other order, and a header before the stored voxels
  // gives the chunk's own extents, which are smaller at the upper ends of the array.
  bool is_n5 = false;
  std::vector<std::string> notes;  // for people, one line each: members that mean nothing

  size_t axes() const { return shape.size(); }
  uint64_t chunkBytes() const;  // decoded; at most kMostChunkBytes
  // Chunks of the whole array, numbered with the last axis fastest. Requires: inside the array.
  int64_t chunkCount() const;
  int64_t chunkNumber(std::span<const int64_t> index) const;
  std::vector<int64_t> chunkIndex(int64_t number) const;
  // The same of the files; their number along an axis.
  int64_t fileCount() const;
  int64_t filesAlong(size_t axis) const;
  int64_t fileNumber(std::span<const int64_t> index) const;
  std::vector<int64_t> fileIndex(int64_t number) const;
  // A file relative to the array's folder: "0.3.1", "0/3/1" or "c/0/3/1".
  std::string fileName(int64_t number) const;
  // The file that holds a chunk, and the chunk's number among those of that file.
  struct Place {
    int64_t file = 0, chunk = 0;
  };
  Place placeOf(int64_t chunk) const;
  // Chunks of a file, those beyond the array included.
  int64_t chunksAFile() const;
  // Bytes of a shard's index with its checksum. Requires: shards.
  uint64_t shardIndexBytes() const;
};

// Blosc's limit for a buffer.
constexpr uint64_t kMostChunkBytes = (uint64_t{1} << 31) - 17;
constexpr size_t kMostZarrAxes = 5;

// The largest index of a shard, in chunks: 64 MiB.
constexpr int64_t kMostChunksAFile = int64_t{1} << 22;

// Throws Error, which starts with `path`, when the text is neither a .zarray nor the zarr.json of
// an array, or one of an array that cannot be read: filters, more than 5 axes, types other than
// integers of 8 to 32 bits and floats of 32 and 64 (bool is read as u8), other codecs, shards
// inside shards.
ZarrArray parseZarrArray(std::string_view text, const std::string& path);

// Whether a zarr.json is an array's, not a group's. Throws Error, which starts with `path`:
// neither.
bool isZarrArray(std::string_view text, const std::string& path);

}  // namespace sluice

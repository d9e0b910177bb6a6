// Growing boxes and their trees as bytes, for the index of a volume. src/index/index_file.h
// documents where an index is kept and how a torn file is rejected; box_store.h reads and writes it
// here.
//
// Bytes are validated as if they came from anyone: a tree that is returned is one that boxTree()
// could have made as far as its readers rely on it. Its leaves share the block out, because their
// boxes follow from the planes and are not stored; children come after their parent, no path is
// deeper than a traversal allows, and every leaf has a texture that holds it. Numbers are in this
// machine's byte order. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/classify/boxes/box_tree.h"
#include "src/volume/block_layout.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// Version of the format: raised when the bytes, or the meaning of a partition, change.
inline constexpr uint32_t kBoxesVersion = 1;

// The bytes of a tree, which deserializeBoxTree() reads.
std::vector<std::byte> serialize(const BoxTree& tree);
// The tree of a block of `cells` cells.
std::optional<BoxTree> deserializeBoxTree(std::span<const std::byte> bytes, Vec3i cells);

// The trees of a run of blocks, by id: the unit of reading and writing.
struct BoxesPiece {
  int64_t first = 0;             // id of the first block
  std::vector<uint64_t> ends;    // end of each block's bytes in `bytes`, ascending
  std::vector<std::byte> bytes;  // all trees; none for a block that was not partitioned

  // Requires: first <= block < first + ends.size().
  std::span<const std::byte> treeBytes(int64_t block) const;
};

// The origin of a piece: bytes for other blocks or parameters are rejected.
struct BoxesOrigin {
  BlockLayout layout;
  ValueMap map;
  GrowingParameters parameters;
  int64_t brick_side = 0;
};
// The bytes of a piece, with the origin that it was made from.
std::vector<std::byte> serialize(const BoxesPiece& piece, const BoxesOrigin& origin);
// nullopt when the bytes are no piece of that origin which begins at `first` and has `count`
// blocks.
std::optional<BoxesPiece> deserializeBoxesPiece(std::span<const std::byte> bytes,
                                                const BoxesOrigin& origin, int64_t first,
                                                int64_t count);

}  // namespace sluice

// Growing boxes and their trees as bytes, for the index beside a volume. Where and how an index is
// kept, and that a torn file is not believed, is src/index/index_file.h; who reads and writes it
// here is box_store.h.
//
// What is read is checked as if it came from anyone: a tree that is given back is one that
// boxTree() could have made as far as its readers rely on it. Its leaves share the block out,
// because their boxes follow from the planes and are not stored; children come after their parent,
// no path is deeper than a traversal allows, and every leaf has a texture that holds it. In this
// machine's byte order. Pure functions, any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/classify/boxes/box_tree.h"
#include "src/volume/block_layout.h"
#include "src/volume/device_voxel.h"

namespace sluice {

// Of the bytes' meaning: goes up when they, or what a partition is, change.
inline constexpr uint32_t kBoxesVersion = 1;

std::vector<std::byte> serialize(const BoxTree& tree);
// Of a block of so many cells. nullopt when the bytes are no tree of it.
std::optional<BoxTree> deserializeBoxTree(std::span<const std::byte> bytes, Vec3i cells);

// The trees of a run of blocks, by id: what is read and written at a time.
struct BoxesPiece {
  int64_t first = 0;             // id of the first block
  std::vector<uint64_t> ends;    // of each block's bytes in `bytes`, ascending
  std::vector<std::byte> bytes;  // of all trees; none for a block that was not partitioned

  // Requires: first <= block < first + ends.size().
  std::span<const std::byte> treeBytes(int64_t block) const;
};

// What a piece is of: bytes for other blocks or parameters are refused.
struct BoxesOrigin {
  BlockLayout layout;
  ValueMap map;
  GrowingParameters parameters;
  int64_t brick_side = 0;
};
std::vector<std::byte> serialize(const BoxesPiece& piece, const BoxesOrigin& origin);
// nullopt when the bytes are no piece of that origin which begins at `first` and has `count`
// blocks.
std::optional<BoxesPiece> deserializeBoxesPiece(std::span<const std::byte> bytes,
                                                const BoxesOrigin& origin, int64_t first,
                                                int64_t count);

}  // namespace sluice

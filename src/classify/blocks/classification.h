// VisibleBlocks: which blocks are white, grey or black, and the object box of each that is not
// white (Tong 1999, section 3.2.2), from the min-max arrays and the opacity table alone.
//
// The paper bounds object voxels; we bound cells. A sample between two voxel planes interpolates
// both, so cell slab i of an axis is empty when nothing is opaque on the whole interval that planes
// i and i+1 span. The object box is the box of the non-empty slabs of the three axes. A block whose
// values are not known may show something in every cell: it is black.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/threads/worker_pool.h"
#include "src/classify/blocks/cut_summary.h"
#include "src/classify/transfer/opacity_table.h"
#include "src/volume/block_name.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

enum class BlockClass : uint8_t {
  kWhite,  // no cell can show anything
  kGrey,   // something is trimmed off
  kBlack,  // the object box is all the block's cells
};

struct ObjectBlock {
  BlockName name;  // time: the step that it is read from
  Box3 cells;      // the object box: cells of the volume, inside the block's owned cells
  BlockClass kind = BlockClass::kGrey;
  int trimming_axis = 2;  // the shortest side of the object box; the last of equals
  // The faces of the block's region beside which no block of its own level is drawn, in a cut of
  // several levels whose look has surfaces: bit a for the lower face across axis a, bit 3 + a for
  // the upper one.
  unsigned level_faces = 0;
};

// A face, an edge or a corner at which a block of a cut meets a coarser one. Both blocks draw their
// surfaces in cells of the finer one, see LevelFade.
struct LevelSeam {
  BlockName fine, coarse;
  Box3 cells;  // those of the finer block next to the coarser one
  // The finer block's face, or the faces that its edge or corner lies on, by the bits of
  // ObjectBlock::level_faces.
  unsigned faces = 0;

  bool isFace() const { return std::has_single_bit(faces); }

  friend bool operator==(const LevelSeam&, const LevelSeam&) = default;
};

// The shortest side of a box of this size; the last of equals.
int shortestAxis(Vec3i size);

// A rank's share of the finest blocks, for algorithms that load blocks in which nothing is visible.
struct BlockShare {
  std::vector<int64_t> blocks;  // ascending
  Box3 cells;                   // cells outside of it belong to other ranks
};

struct VisibleBlocks {
  std::vector<ObjectBlock> blocks;  // grey and black ones, ascending by block
  int64_t white = 0, grey = 0, black = 0;
  std::optional<CutSummary> cut;  // for a volume of several levels
  // Coarser blocks, ascending, in whose place the cut has finer ones.
  std::vector<BlockName> refined = {};
  // Those that CutSummary::thin_blocks counts before anything is read, ascending.
  std::vector<BlockName> thin = {};
  // The seams of the whole picture, of which these may be a rank's blocks: ascending by the finer
  // block, whose faces come first. Empty if there are no surfaces.
  std::vector<LevelSeam> seams = {};
  // On several ranks, if every block is loaded; unset: all blocks belong to this process.
  std::optional<BlockShare> share = {};
};

// `crop`: cells that may show at all (the whole volume's by default); blocks and boxes are cut by
// it. `time` is the step that the ranges are of. Throws Error when a sparse volume's background
// would be visible in more blocks than can be listed.
VisibleBlocks classify(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                       WorkerPool& pool, int64_t time = 0);

// How many blocks classify() lists, without the list, which may be larger than what memory there
// is.
int64_t countVisible(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                     WorkerPool& pool);

// classify() for pictures whose samples show values up to a voxel from them on each axis
// (FrameSetup::integrates): object boxes take in every cell within a voxel of one that may show
// something, in their own block or in another.
VisibleBlocks classifyAround(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                             WorkerPool& pool, int64_t time = 0);

}  // namespace sluice

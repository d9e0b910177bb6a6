// The texture blocks of a plan, before they have chunks and clusters.
#include <algorithm>
#include <bit>

#include "src/base/error.h"
#include "src/texture/texture_plan.h"

namespace sluice {
namespace {

// The whole block, drawn whole (I) or clipped to its object box (II).
TextureBlock wholeBlock(const PyramidLayout& pyramid, const ObjectBlock& object) {
  const BlockLayout& layout = pyramid.of(object.name).blocks;
  const int64_t side = sideOf(pyramid);
  TextureBlock result;
  result.name = object.name;
  result.voxels = layout.cube(layout.indexOf(object.name.block));
  // In a volume smaller than a block, cubes are larger than the side that chunks and budgets are
  // made for.
  result.voxels.hi = result.voxels.lo + Vec3i{side, side, side};
  result.cells = object.cells;
  result.level_faces = object.level_faces;
  return result;
}

// Section 3.2.2: trimmed along one axis, 2^d along the others.
TextureBlock trimmedBlock(const PyramidLayout& pyramid, const ObjectBlock& object) {
  TextureBlock result = wholeBlock(pyramid, object);
  const int axis = result.trimming_axis = object.trimming_axis;
  const LevelLayout& level = pyramid.of(object.name);
  const Box3 needed = level.voxelsUnder(object.cells), cube = result.voxels;
  // The ghost layers around the object box are kept, too: gradients at its border use them.
  result.voxels.lo[axis] = std::max(cube.lo[axis], needed.lo[axis] - level.blocks.ghost);
  result.voxels.hi[axis] = std::min(cube.hi[axis], needed.hi[axis] + level.blocks.ghost);
  return result;
}

// The texels of the coarser block that a seam needs.
TextureBlock seamBlock(const PyramidLayout& pyramid, const VisibleBlocks& visible, size_t number,
                       Algorithm algorithm) {
  const LevelSeam& seam = visible.seams[number];
  ObjectBlock object;
  object.name = seam.coarse;
  object.cells = seam.cells;
  object.trimming_axis = std::countr_zero(seam.faces) % 3;  // a seam is thin across its face
  TextureBlock result =
      loadsWholeBlocks(algorithm) ? wholeBlock(pyramid, object) : trimmedBlock(pyramid, object);
  result.seam = static_cast<int32_t>(number);
  return result;
}

// Visits the block, and its seams behind it.
void visitWithSeams(const PyramidLayout& pyramid, const VisibleBlocks& visible, Algorithm algorithm,
                    const TextureBlock& block,
                    const std::function<void(const TextureBlock&)>& visit) {
  visit(block);
  if (visible.seams.empty()) return;
  const auto first = std::ranges::lower_bound(visible.seams, block.name, {}, &LevelSeam::fine);
  for (auto seam = first; seam != visible.seams.end() && seam->fine == block.name; ++seam)
    visit(
        seamBlock(pyramid, visible, static_cast<size_t>(seam - visible.seams.begin()), algorithm));
}

}  // namespace

bool areOfSeveralLevels(const VisibleBlocks& visible) {
  // The cut belongs to the whole picture: a rank whose own blocks are all of the finest level must
  // decide as the others do.
  if (visible.cut) return !visible.cut->levels.empty() && visible.cut->levels.back().level > 0;
  const auto isAbove = [](const ObjectBlock& object) { return object.name.level > 0; };
  return std::ranges::any_of(visible.blocks, isAbove);
}

bool loadsEveryBlock(const VisibleBlocks& visible, Algorithm algorithm) {
  return loadsWholeBlocks(algorithm) && !areOfSeveralLevels(visible);
}

void requireListable(const BlockLayout& layout, Algorithm algorithm) {
  if (layout.blockCount() > kMostListedBlocks)
    failRequest("--algorithm {} loads every block, here {}; use trimmed or merged", name(algorithm),
                layout.blockCount());
}

void visitTextureBlocks(const PyramidLayout& pyramid, const VisibleBlocks& visible,
                        const PlanOptions& options,
                        const std::function<void(const TextureBlock&)>& visit) {
  const Algorithm algorithm = options.algorithm;
  if (!loadsWholeBlocks(algorithm)) {
    for (const ObjectBlock& object : visible.blocks)
      visitWithSeams(pyramid, visible, algorithm, trimmedBlock(pyramid, object), visit);
    return;
  }
  if (!loadsEveryBlock(visible, algorithm)) {
    for (ObjectBlock object : visible.blocks) {
      // Algorithm I draws the whole region of a block, since it knows no object boxes. Those of
      // coarser levels belong to the picture: voxels with spreads show something beyond them, where
      // the finest level shows nothing. Only blocks of the cut are loaded, for regions of other
      // levels overlap them.
      if (algorithm == Algorithm::kConventional && object.name.level == 0)
        object.cells = intersect(pyramid.regionOf(object.name), options.crop);
      visitWithSeams(pyramid, visible, algorithm, wholeBlock(pyramid, object), visit);
    }
    return;
  }
  const BlockLayout& layout = pyramid.finest();
  requireListable(layout, algorithm);
  const BlockShare* share = visible.share ? &*visible.share : nullptr;
  const int64_t count =
      share != nullptr ? static_cast<int64_t>(share->blocks.size()) : layout.blockCount();
  const Box3 drawn = share != nullptr ? intersect(options.crop, share->cells) : options.crop;
  size_t next = 0;
  for (int64_t i = 0; i < count; ++i) {
    const int64_t block = share != nullptr ? share->blocks[static_cast<size_t>(i)] : i;
    ObjectBlock object;
    // A block that shows nothing has no cells: algorithm II loads it and draws nothing of it.
    object.name = {.time = options.time, .block = block};
    if (next < visible.blocks.size() && visible.blocks[next].name.block == block)
      object = visible.blocks[next++];
    if (algorithm == Algorithm::kConventional)
      object.cells = intersect(layout.ownedCells(layout.indexOf(block)), drawn);
    visit(wholeBlock(pyramid, object));
  }
}

}  // namespace sluice

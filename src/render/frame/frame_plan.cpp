#include "src/render/frame/frame_plan.h"

#include <unordered_set>

namespace sluice {

FramePlan makeFramePlan(const TimeStep& step, const VisibleBlocks& visible,
                        const PageGeometry& page, const PlanOptions& options, ChunkNames& names) {
  const PyramidLayout layout = step.layout();
  FramePlan plan;
  plan.textures = planTextures(layout, visible, page, options);
  plan.names = names.namesOf(plan.textures);
  plan.pages = plan.textures.pageCount();
  const VoxelType type = step.source->layout().type;
  // A block of a seam is decoded once, for itself or for the first seam that needs it.
  std::unordered_set<BlockName, BlockNameHash> decoded;
  if (!visible.seams.empty())
    for (const ObjectBlock& block : visible.blocks) decoded.insert(block.name);
  for (const TextureBlock& block : plan.textures.blocks) {
    const Box3 stored = layout.storedVoxels(block.name);
    const int numbers = layout.of(block.name).numbers;
    if (!block.isOfSeam() || decoded.insert(block.name).second)
      plan.rebuild.decoded +=
          static_cast<uint64_t>(stored.count()) * storedBytesPerVoxel(type, numbers);
    plan.rebuild.copied +=
        static_cast<uint64_t>(block.voxels.count() * page.bytes_per_voxel * numbers);
    if (block.isOfSeam()) continue;  // its cells are those of a block that counts
    plan.hull = unite(plan.hull, block.cells);
    plan.cells += block.cells.count();
  }
  plan.rebuild.uploaded = plan.textures.bytes();
  return plan;
}

}  // namespace sluice

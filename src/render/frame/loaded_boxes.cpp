#include "src/render/frame/loaded_boxes.h"

#include "src/base/threads/clock.h"

namespace sluice {

BoxDraw boxDraw(const TexturePlan& textures, const TextureBlock& block) {
  // From finest voxels to the level's, from these to the chunk's: the maps are put together, axis
  // by axis.
  const LevelPlacement& level = textures.pyramid.of(block.name).placement;
  BoxDraw box;
  box.cells = block.cells;
  TexelMap& texels = box.texels;
  texels.axes = textureAxes(block.trimming_axis);
  for (int a = 0; a < 3; ++a) {
    const int axis = texels.axes[static_cast<size_t>(a)];
    texels.scale[a] = 1 / level.scale[axis];
    texels.offset[a] = static_cast<double>(block.at[a] - block.voxels.lo[axis]) -
                       level.offset[axis] / level.scale[axis];
  }
  return box;
}

void loadChunks(const ReadAhead::Taken& taken, const FramePlan& plan, ReadAhead& ahead,
                Residency& residency, bool may_lack, FrameReport& report,
                const std::function<void(ChunkPosition, ChunkName)>& request) {
  for (size_t i = 0; i < taken.texels.size(); ++i) {
    const ChunkPosition chunk = taken.step.chunks[i];
    const ChunkName name = plan.names[chunk];
    ChunkTexelsPtr texels = taken.texels[i];
    // The texels come first: a chunk that cannot be read is one that the model was never asked for.
    if (texels == nullptr && !residency.isResident(name)) {
      if (may_lack) continue;
      texels = ahead.takeOne(chunk);
    }
    // The trace has the requests in the order in which the model gets them.
    if (request) request(chunk, name);
    const Residency::Made made = residency.makeResident(plan, chunk, texels);
    report.pages_loaded += made.pages;
    report.uploaded_bytes += made.copied_bytes;
    report.stages.upload += made.seconds;
  }
}

FrameReport reportWithoutBlocks(const VisibleBlocks& visible, double step_vox) {
  FrameReport report;
  report.step_vox = step_vox;
  report.blocks.white = visible.white;
  report.cut = visible.cut;
  return report;
}

void addCounts(const VisibleBlocks& visible, const FramePlan& plan, const ReadTally& tally,
               FrameReport& report) {
  report.decoded_bytes = tally.decoded_bytes;
  report.copied_bytes = tally.copied_bytes;
  report.stages.read = secondsOf(tally.read_ns);
  report.stages.decode = secondsOf(tally.decode_ns);
  report.stages.copy = secondsOf(tally.copy_ns);
  report.blocks = {visible.white, visible.grey, visible.black};
  report.cut = visible.cut;
  report.clusters = static_cast<int64_t>(plan.textures.clusters.size());
  report.chunks = static_cast<int64_t>(plan.textures.chunks.size());
  report.pages = plan.pages;
  report.rebuild = plan.rebuild;
}

}  // namespace sluice

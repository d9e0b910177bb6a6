#include "tools/scene_session.h"

#include <algorithm>

#include "src/base/bytes.h"
#include "src/base/error.h"
#include "src/classify/blocks/classification.h"
#include "src/render/look.h"

namespace sluice {
namespace {

// The blocks that may be held at once by a cut without a view, whatever shows.
uint64_t blocksOfCut(const IndexedVolume& volume, const CutOptions& cut) {
  if (cut.level && *cut.level < volume.pyramid->levels())
    return static_cast<uint64_t>(volume.pyramid->level(*cut.level).blocks.blockCount());
  const int64_t side = volume.layout.size;
  const uint64_t block_bytes =
      static_cast<uint64_t>(sluice::volume({side, side, side})) * bytesPerVoxel(volume.map.type);
  return std::min(cut.most_held_bytes / block_bytes + 1,
                  static_cast<uint64_t>(volume.layout.blockCount()));
}

// Bytes of the frame's plan for the step that the volume was opened for.
uint64_t planBytes(const Scene& scene, const FrameOptions& frame, WorkerPool& pool) {
  if (scene.volume.stand_in) return blocksOfCut(scene.volume, *frame.cut) * kPlannedBlockBytes;
  const SliceRanges& ranges = scene.volume.index->ranges;
  const Look look = makeLook(scene.volume.step(), scene.transfer, frame.mode);
  const VisibleBlocks shown =
      classify(ranges, look.table, cropCells(frame, ranges.layout.dims), pool, scene.volume.time);
  return shown.blocks.size() * kPlannedBlockBytes;
}

}  // namespace

BesideShare besideShare(const IndexedVolume& volume, const ResourceArguments& resources,
                        Partition partition, const PictureDemand& picture, uint64_t others_bytes) {
  const uint64_t memory_bytes = memoryBudget(resources);
  BesideShare share;
  for (const uint64_t of_memory : {memory_bytes, uint64_t{0}}) {
    share.picture_bytes = pictureBytes(picture, of_memory);
    share.beside_bytes = others_bytes + share.picture_bytes;
    PageGeometry page = volume.page;
    page.pages = pageCount(resources, volume, share.beside_bytes);
    share.pages = page.pages;
    BufferNeeds needs = bufferNeeds(*volume.source, volume.layout, partition, share.beside_bytes);
    needs.numbers = volume.numbers();
    if (textureMemoryBytes(page, TexelPlace::kInMemory) + leastBufferBytes(page, needs) <=
        memory_bytes)
      break;
  }
  return share;
}

void openSession(Scene& scene, const ResourceArguments& resources, const FrameOptions& frame,
                 uint64_t more_bytes) {
  IndexedVolume& volume = scene.volume;
  const uint64_t others_bytes =
      volume.rangesBytes() + planBytes(scene, frame, scene.pool) + more_bytes;
  BesideShare share = besideShare(volume, resources, frame.partition, scene.pictures, others_bytes);
  if (scene.share) {  // ranks have parts in the picture's place, and the first one the picture
    const auto pixels =
        static_cast<uint64_t>(frame.size.width) * static_cast<uint64_t>(frame.size.height);
    const uint64_t picture_bytes = scene.part_bytes + pixels * kComposedPixelBytes;
    if (picture_bytes > scene.memory_bytes)
      fail(
          "--memory {} is too small: the picture takes {} on each rank; give more --memory or a "
          "smaller --size",
          formatBytes(scene.memory_bytes), formatBytes(picture_bytes));
    share.beside_bytes = others_bytes + picture_bytes;
    share.pages = pageCount(resources, volume, share.beside_bytes);
  } else {
    scene.part_bytes = share.picture_bytes;
  }
  volume.page.pages = share.pages;
  SessionOptions options =
      sessionOptions(volume, scene.look.lit, resources, frame.partition, scene.memory_bytes);
  options.beside_bytes = share.beside_bytes;
  scene.session.reset();
  scene.session = std::make_unique<Session>(volume.step(), *scene.device, scene.pool, options);
  scene.session->setTransferFunction(scene.transfer);
  scene.chooseBlocksBy(nullptr);
}

}  // namespace sluice

#include "tools/scene/scene_session.h"

#include "src/base/error.h"
#include "src/base/values/bytes.h"

namespace sluice {

uint64_t othersBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                     const FrameOptions& frame, WorkerPool& pool) {
  // A series also holds the ranges of the step that is shown and of the next one.
  const uint64_t steps = volume.source->layout().time_steps > 1 ? 3 : 1;
  return steps * volume.rangesBytes() + planBytes(volume, transfer, frame, pool);
}

void openSession(Scene& scene, const ResourceArguments& resources, const FrameOptions& frame,
                 uint64_t more_bytes) {
  IndexedVolume& volume = scene.volume;
  const uint64_t others_bytes = othersBytes(volume, scene.transfer, frame, scene.pool) + more_bytes;
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
  scene.beside_bytes = share.beside_bytes;
  SessionOptions options =
      sessionOptions(volume, scene.look.lit, resources, frame.partition, scene.memory_bytes);
  options.beside_bytes = share.beside_bytes;
  scene.session.reset();
  scene.session = std::make_unique<Session>(volume.step(), *scene.device, scene.pool, options);
  scene.session->setTransferFunction(scene.transfer);
  scene.chooseBlocksBy(nullptr);
}

}  // namespace sluice

// The session of a scene, and the part of --memory that it leaves to others.
#pragma once

#include <memory>

#include "src/library/picture_memory.h"
#include "tools/scene/scene.h"

namespace sluice {

// The bytes held in addition to the levels, and the pages of the texture cache that they leave room
// for.
struct BesideShare {
  uint64_t picture_bytes = 0, beside_bytes = 0;
  int64_t pages = 0;
};
// The bytes that a frame holds in addition to the levels and the picture: min-max arrays, plans.
uint64_t othersBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                     const FrameOptions& frame, WorkerPool& pool);
// `others_bytes`: min-max arrays and whatever else is held. The picture gets a quarter of the
// memory if the levels then have the least that they work with, otherwise the least strip.
BesideShare besideShare(const IndexedVolume& volume, const ResourceArguments& resources,
                        Partition partition, const PictureDemand& picture, uint64_t others_bytes);

// Sets scene.session, and the scene's number of pages, so that the levels leave room for the
// min-max arrays, pictures or parts of them, a frame's plan and `more_bytes`. The contents of an
// earlier session are lost. Throws Error if the memory is too little.
void openSession(Scene& scene, const ResourceArguments& resources, const FrameOptions& frame,
                 uint64_t more_bytes);

}  // namespace sluice

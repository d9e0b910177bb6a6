// The session of a scene, and the part of --memory that it leaves to others.
#pragma once

#include <memory>

#include "src/library/drawing/resources.h"
#include "tools/scene/scene.h"

namespace sluice {

// The bytes that a frame holds in addition to the levels and the picture: min-max arrays, plans.
uint64_t othersBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                     const FrameOptions& frame, WorkerPool& pool);

// Sets scene.session, and the scene's number of pages, so that the levels leave room for the
// min-max arrays, pictures or parts of them, a frame's plan and `more_bytes`. The contents of an
// earlier session are lost. Throws Error if the memory is too little.
void openSession(Scene& scene, const ResourceArguments& resources, const FrameOptions& frame,
                 uint64_t more_bytes);

}  // namespace sluice

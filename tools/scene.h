// Scene: a volume opened for a command: source, index, device, session, and the transfer function
// that the options ask for. It only puts library calls together.
#pragma once

#include <memory>
#include <string>

#include "src/base/worker_pool.h"
#include "src/render/session.h"
#include "src/volume/indexed_ranges.h"
#include "tools/arguments.h"

namespace sluice {

// A volume with its min-max arrays; no device.
struct IndexedVolume {
  std::unique_ptr<VolumeSource> source;
  ValueMap map;
  PageGeometry page;
  BlockLayout layout;
  IndexedRanges index;

  // Least and greatest value of the volume.
  ValueRange valueRange() const;
};
// Opens the volume and reads or builds its index. Throws Error. `gradients`: with a ghost layer.
IndexedVolume openIndexed(const VolumeArguments& volume, const ResourceArguments& resources,
                          bool gradients, WorkerPool& pool);

// Whether a picture of this look takes gradients: blocks then carry a ghost layer. Throws Error
// from a transfer function's file.
bool needsGradients(const LookArguments& look);
TransferFunction transferFor(const IndexedVolume& volume, const LookArguments& look);

// The classification and the plan of a frame, without a device.
struct PlannedFrame {
  TexturePlan plan;
  double classify_seconds = 0, plan_seconds = 0;
};
PlannedFrame planFrame(const IndexedVolume& volume, const TransferFunction& transfer,
                       const FrameOptions& options, int64_t time, WorkerPool& pool);

SessionOptions sessionOptions(const VolumeArguments& volume, const PageGeometry& page,
                              const LookArguments& look, const ResourceArguments& resources,
                              Partition partition, uint64_t memory_bytes);

struct Scene {
  // `partition`: kBoxes where frames may ask for growing boxes.
  Scene(const VolumeArguments& volume, const LookArguments& look,
        const ResourceArguments& resources, Partition partition);

  WorkerPool pool;
  IndexedVolume volume;
  uint64_t memory_bytes;
  std::unique_ptr<Device> device;
  TransferFunction transfer;
  std::unique_ptr<Session> session;
};

// What --memory means when it is not given: half of what the machine or its cgroup has.
uint64_t memoryBudget(const ResourceArguments& resources);

}  // namespace sluice

// Opens volumes and scenes for commands. It only puts calls of the library together, and prints
// their warnings and progress.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/library/drawing/scene/scene.h"
#include "src/library/drawing/view_fit.h"
#include "tools/command_line/outputs.h"
#include "tools/options/arguments.h"
#include "tools/scene/workers.h"

namespace sluice {

// A pass within the memory of the options or of a scene, which a signal ends.
IndexPass passOf(WorkerPool& pool, ProgressMeter& progress, const ResourceArguments& resources);
IndexPass passOf(const Scene& scene, ProgressMeter& progress);

// Opens the volume, checks the files that the command will write against those it is read from,
// reads or builds its index, and prints its notes. Throws Error.
IndexedVolume openIndexed(const VolumeArguments& volume, const ResourceArguments& resources,
                          const IndexNeeds& needs, WorkerPool& pool,
                          const Outputs& outputs = Outputs());
// The same of one of several, without outputs. `said`: the notes that were printed; new ones are
// added.
IndexedVolume openIndexed(const VolumeArguments& volume, const ResourceArguments& resources,
                          const IndexNeeds& needs, WorkerPool& pool,
                          std::vector<std::string>& said);

// Needs of a picture with these options. A cut through levels may be opened with a stand-in
// (stand_in.h) if `finest` allows it, and with a sample (volume_sample.h) if it allows that.
enum class FinestLevel { kRead, kMayWait, kMaySample };
IndexNeeds pictureNeeds(const LookArguments& look, const FrameOptions& frame, FinestLevel finest);
// The same for each channel that a picture with these options shows (shown_channels.h), with the
// needs of its own look.
std::vector<IndexedVolume> openIndexedChannels(const VolumeArguments& volume,
                                               const LookArguments& look,
                                               const ResourceArguments& resources,
                                               const FrameOptions& frame, FinestLevel finest,
                                               WorkerPool& pool, const Outputs& outputs);
// Whether pictures from these cameras of a volume with a stand-in have to wait for the index of
// the finest level: they show that level, and no limit of bytes or time stands against it. `first`:
// the layout of the volume that frame and cameras are for.
bool mustReadFinest(const IndexedVolume& volume, const TransferFunction& transfer,
                    const VolumeLayout& first, const FrameOptions& frame,
                    std::span<const Camera> cameras, WorkerPool& pool);
// The same for any channel of a scene.
bool mustReadFinest(const Scene& scene, const FrameOptions& frame, std::span<const Camera> cameras);

// fitCameras() with progress, until a signal comes.
void fitCameras(std::vector<Camera>& cameras, FitChoice choice, const FitRequest& request,
                Room room, const ResourceArguments& resources, WorkerPool& pool);
// depthPoints() in the same way.
std::shared_ptr<const std::vector<Vec3d>> depthPoints(const FitRequest& request,
                                                      const ResourceArguments& resources,
                                                      WorkerPool& pool);

// lookFor() of a composite picture.
TransferFunction transferFor(const IndexedVolume& volume, const LookArguments& look);

// The channels of a scene, for fits.
std::vector<FittedVolume> fittedVolumes(const Scene& scene);

// Opens the volume and makes a scene of the channels that pictures show, for frames like this one;
// of a team each rank does so. Throws Error.
Scene openScene(const VolumeArguments& volume, const LookArguments& look,
                const ResourceArguments& resources, const FrameOptions& frame,
                const Outputs& outputs = Outputs(), Team* team = nullptr,
                FinestLevel finest = FinestLevel::kRead);

// Whether a picture of one step of a series looks at all steps: its view is fitted to them. Then
// its values have the range of all, as in a picture of several steps, of which tables and light
// follow.
bool looksAtAllSteps(const LookArguments& look, const FrameOptions& frame, FitChoice fit);

}  // namespace sluice

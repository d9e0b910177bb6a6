#include "src/library/drawing/scene/opened_scene.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/library/conversions.h"
#include "src/library/in_situ.h"

namespace sluice {

FrameOptions sessionFrame(const OpenedVolume* opened, const LookOptions& look,
                          const RendererOptions& options) {
  FrameOptions frame;
  frame.mode = modeOf(look);
  frame.size = {std::max(0, options.rows_width), std::max(0, options.rows_height)};
  if (opened->in_situ != nullptr) frame.crop = opened->in_situ->ownVoxels();
  setPipeline(options.pipeline, frame);
  if (opened->in_situ != nullptr && frame.algorithm == Algorithm::kConventional)
    failRequest("pipeline.algorithm conventional draws blocks whole, of which a rank has parts");
  return frame;
}

Scene sceneOf(const std::shared_ptr<const OpenedVolume>& opened, const LookOptions& look,
              const RendererOptions& options) {
  const MachineOptions machine = machineOptions(options);
  std::vector<std::shared_ptr<const IndexedVolume>> more;
  for (const IndexedVolume& volume : opened->more) more.emplace_back(opened, &volume);
  // A rank that has all of the volume draws it alone.
  const InSitu* in_situ = opened->in_situ.get();
  if (in_situ != nullptr && in_situ->team().ranks() == 1) in_situ = nullptr;
  return {{.pool = std::make_shared<WorkerPool>(machine.threads),
           .volume = {opened, &opened->volume},
           .more = std::move(more),
           .machine = machine,
           .team = in_situ == nullptr ? nullptr : &in_situ->team(),
           .lent = in_situ == nullptr ? nullptr : in_situ->boxes,
           .may_be_lit = true},
          lookArguments(look, opened->whole_series),
          sessionFrame(opened.get(), look, options)};
}

}  // namespace sluice

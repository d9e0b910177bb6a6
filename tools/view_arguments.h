// From a command's arguments to what the public library takes, for the window, which is drawn by
// that alone. Pure functions.
#pragma once

#include <sluice/options.h>
#include <sluice/volume.h>

#include "src/render/frame_options.h"
#include "src/view/state/view_state.h"
#include "tools/arguments.h"

namespace sluice {

ViewedVolume viewedVolume(const VolumeArguments& volume, const ResourceArguments& resources,
                          const std::string& index_folder);
LookOptions lookOptions(const LookArguments& look, Mode mode);
// The volume is opened whole, and so its range is that of all steps.
ViewState viewState(const VolumeArguments& volume, const LookArguments& look,
                    const FrameOptions& frame, const FitChoice& fit, bool has_step);
RendererOptions rendererOptions(const ResourceArguments& resources);

}  // namespace sluice

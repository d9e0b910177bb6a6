// Converts a command's arguments to the public library's, for the window, which uses only that
// library to draw. Pure functions.
#pragma once

#include <sluice/options.h>
#include <sluice/volume.h>

#include "src/render/camera/frame_options.h"
#include "src/view/state/view_state.h"
#include "tools/options/arguments.h"

namespace sluice {

ViewedVolume viewedVolume(const VolumeArguments& volume, const ResourceArguments& resources,
                          const std::string& index_folder);
LookOptions lookOptions(const LookArguments& look, Mode mode);
// The volume is opened whole, so its range covers all steps.
ViewState viewState(const VolumeArguments& volume, const LookArguments& look,
                    const FrameOptions& frame, const FitChoice& fit, bool has_step);
RendererOptions rendererOptions(const ResourceArguments& resources);

}  // namespace sluice

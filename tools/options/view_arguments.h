// Converts a command's arguments to the public library's, for the window, which uses only that
// library to draw. Pure functions.
#pragma once

#include <sluice/options.h>
#include <sluice/volume.h>

#include "src/options/view_state.h"
#include "tools/options/arguments.h"

namespace sluice {

// `whole_series`: see VolumeOptions.
ViewedVolume viewedVolume(const VolumeArguments& volume, const ResourceArguments& resources,
                          const std::string& index_folder, bool whole_series);
// The cache and the key with which these paths are read if they are addresses. Throws Error as
// bucketAccess() does.
VolumeOptions::Web webOf(const WebOptions& web, const std::vector<std::string>& paths);
// The view that was asked for, with the time step and the flags of the look, which the options hold
// apart. The volume is opened whole, so its range covers all steps.
ViewState viewState(const ViewState& asked, const VolumeArguments& volume,
                    const LookArguments& look);
RendererOptions rendererOptions(const ResourceArguments& resources);

}  // namespace sluice

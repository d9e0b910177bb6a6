// Draws a state into a picture file, for code that has a renderer.
#pragma once

#include <sluice/progress.h>
#include <sluice/renderer.h>

#include <stop_token>
#include <string>

#include "src/options/view_state.h"
#include "src/view/state/view_path.h"

namespace sluice {

// Throws Error if the name ends in neither .png nor .exr (in any case).
void requirePictureName(const std::string& path);

// Draws the state, with the look that the renderer has, complete: a PNG, or an EXR with depth in
// composite mode. Requires: requirePictureName() passes. Throws as Renderer::draw() does, and Error
// if the file cannot be written.
void drawToFile(Renderer& renderer, const std::string& path, const ViewState& state, int width,
                int height, const ProgressFunction& progress, const std::stop_token& stop);

// Gives the volume's up direction to key frames without `up` (Renderer::placed()): a path is
// interpolated by eye, target and up. Throws as Renderer::placed() does.
void placeKeys(ViewPath& path, Renderer& renderer, const ProgressFunction& progress,
               const std::stop_token& stop = {});

}  // namespace sluice

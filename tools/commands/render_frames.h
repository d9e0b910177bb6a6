// The frames of `render`: draws them one after another and writes their pictures.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/threads/deadline.h"
#include "tools/options/render_arguments.h"
#include "tools/outputs/picture_output.h"
#include "tools/outputs/render_report.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/series.h"

namespace sluice {

// What is drawn, and where. All references must outlive the drawing.
struct RenderJob {
  const RenderArguments& arguments;
  const std::vector<int64_t>& to_draw;  // numbers of the frames
  const std::vector<Camera>& cameras;   // one, or one for each frame of the command
  const PictureOutput& output;
  FrameOptions options;  // with the first camera
  Scene& scene;
  bool is_first = true;       // of the ranks: it writes the pictures
  bool has_step = false;      // --step is given, the same for all pictures of a row
  Deadline::TimePoint began;  // of the command: the first frame's time counts from here
  // Pictures of the first frame that were drawn from a sample.
  std::vector<RefinedPicture> earlier = {};
  std::vector<std::string> warnings = {};  // of the command, in addition to the scene's
};

// For a series without a path, one camera shows every step.
const Camera& cameraOf(const std::vector<Camera>& cameras, int64_t frame);

// The options of all frames, with the distance between slices that follows from the first camera
// unless --step is given. Keeps the options of the look, with that distance, as the scene's
// drawn_look.
FrameOptions drawingOptions(const RenderJob& job);

// Draws the one picture that a sample gives. The pass over all voxels follows it, and better
// pictures. Throws Error and Interrupted.
std::vector<RefinedPicture> drawSample(const RenderJob& job);

// Decides for --culling auto before the first picture; frames of turns and paths show one step,
// which is not measured.
void chooseCulling(const RenderJob& job, Series& series);

// Draws the frames and writes their pictures. A signal ends it early if reportsParts(). Throws
// Error and Interrupted.
Drawn drawFrames(const RenderJob& job, Series& series);

}  // namespace sluice

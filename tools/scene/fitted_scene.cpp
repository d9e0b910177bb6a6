#include "tools/scene/fitted_scene.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/library/conversions.h"
#include "tools/command_line/interrupt.h"
#include "tools/scene/ranks.h"

namespace sluice {
namespace {

// A camera per frame, of a turn or along the path; or a single one for all steps of a series.
// Throws Error for a frame of the path whose camera sees nothing, before any frame is drawn.
std::vector<Camera> camerasOf(const RenderArguments& arguments, const VolumeLayout& layout) {
  Camera start = arguments.frame.camera;
  if (!arguments.path) return turnOf(start, arguments.frames);
  start.up = frontAxes(start.view, layout.frame, start.up).up;  // keys move it on
  std::vector<Camera> cameras;
  const int64_t count = frameCount(arguments);
  for (int64_t i = 0; i < count; ++i) try {
      cameras.push_back(cameraAt(*arguments.path, start, i, count));
      requireValid(cameras.back(), layout, arguments.frame.size);
    } catch (const Error& error) {
      failAs(error.kind(), "{}: frame {}, at {:.3g} of the path: {}", arguments.path_file, i,
             placeOnPath(i, count), error.what());
    }
  return cameras;
}

// With several ranks, rank 0 makes the index that the others read.
std::unique_ptr<Scene> openScene(const RenderArguments& arguments, const Outputs& outputs,
                                 Team* team, FinestLevel finest) {
  const auto open = [&] {
    return std::make_unique<Scene>(openScene(arguments.volume, arguments.look, arguments.resources,
                                             arguments.frame, outputs, team, finest));
  };
  if (team == nullptr) return open();
  std::unique_ptr<Scene> scene;
  if (team->isFirst()) scene = open();
  team->wait();
  if (!team->isFirst()) scene = open();
  return scene;
}

// The same for a view that was saved, which must fit the volume.
std::unique_ptr<Scene> openScene(const RenderArguments& arguments,
                                 const std::optional<SavedView>& saved, const Outputs& outputs,
                                 Team* team, FinestLevel finest) {
  if (!saved) return openScene(arguments, outputs, team, finest);
  try {
    std::unique_ptr<Scene> scene = openScene(arguments, outputs, team, finest);
    saved->requireFits(volumeInfo(scene->volume.source->layout(), {}, {}));
    return scene;
  } catch (const Error& error) {
    // The volume knows its step as --time, and the file's fields as options.
    if (!saved->isToBlame(error)) throw;
    failAs(error.kind(), "{}: {}", saved->name, error.what());
  }
}

FittedScene fittedScene(const RenderArguments& arguments, const std::optional<SavedView>& saved,
                        const Outputs& outputs, Team* team, Room room, FinestLevel finest) {
  FittedScene fitted;
  fitted.scene = openScene(arguments, saved, outputs, team, finest);
  Scene& scene = *fitted.scene;
  fitted.asked = camerasOf(arguments, scene.volume.source->layout());
  fitted.cameras = fitted.asked;
  const FitRequest request{fittedVolumes(scene), arguments.frame, arguments.look.this_step};
  fitCameras(fitted.cameras, arguments.fit, request, room, arguments.resources, scene.pool);
  fitted.shown_points = depthPoints(request, arguments.resources, scene.pool);
  return fitted;
}

// Whether the finest level is to be read after all. Ranks read it if any of them must, or if only
// some have its index, as on hosts with cache folders of their own: all must draw the same.
bool mustReadFinest(const FittedScene& fitted, const RenderArguments& arguments, Team* team) {
  const Scene& scene = *fitted.scene;
  const bool must_read = mustReadFinest(scene, arguments.frame, fitted.cameras);
  if (team == nullptr) return must_read;
  Message mine{std::byte{must_read}};
  for (const Layer* layer : scene.layers())
    mine.push_back(std::byte(layer->volume.stand_in ? layer->volume.stand_in->level + 1 : 0));
  return std::ranges::any_of(team->gatherAll(mine), [&](const Message& other) {
    return other != mine || other.front() != std::byte{0};
  });
}

}  // namespace

FittedScene openFitted(const RenderArguments& arguments, const std::optional<SavedView>& saved,
                       const Outputs& outputs, Team* team, Room room, FinestLevel finest) {
  const bool compares = arguments.verify || arguments.debug_view;
  // Ranks open the steps of a series one after the other, each with the finest level.
  if (!compares && (team == nullptr || !isSeries(arguments))) {
    const bool is_row = asksForRefinement(arguments) && !isSeries(arguments) && team == nullptr;
    FittedScene fitted = fittedScene(arguments, saved, outputs, team, room,
                                     is_row ? finest : std::min(finest, FinestLevel::kMayWait));
    // A row of pictures begins with coarse ones at once.
    if (arguments.progressive) return fitted;
    if (!mustReadFinest(fitted, arguments, team)) return fitted;
  }
  return fittedScene(arguments, saved, outputs, team, room, FinestLevel::kRead);
}

}  // namespace sluice

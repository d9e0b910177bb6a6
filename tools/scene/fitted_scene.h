// How `render` opens a scene: the volume with its cameras, fitted to what is visible, and level 0's
// index only where a picture needs it.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tools/options/render_arguments.h"
#include "tools/options/view_state_option.h"
#include "tools/scene/open_scene.h"

namespace sluice {

// A scene with its cameras as the user asked for them, and fitted to what is visible.
struct FittedScene {
  std::unique_ptr<Scene> scene;
  std::vector<Camera> asked, cameras;
  std::shared_ptr<const std::vector<Vec3d>> shown_points;  // see FrameOptions
};

// The finest level is read at the opening only if a picture shows it, or an option compares with
// it. A row of pictures of a volume without levels and index begins with a sample of its voxels, if
// `finest` allows it. With several ranks, rank 0 makes the indices that the others read, and all
// read the finest level or none does; for a series all do. `saved`: a view, which must fit the
// volume. Throws Error, Interrupted.
FittedScene openFitted(const RenderArguments& arguments, const std::optional<SavedView>& saved,
                       const Outputs& outputs, Team* team, Room room,
                       FinestLevel finest = FinestLevel::kMaySample);

}  // namespace sluice

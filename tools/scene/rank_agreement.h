// The options that all ranks of a command must share, and checks of them
// (src/parallel/agreement.h).
//
// Options that determine the picture must be the same. Options of a rank's own machine may differ:
// memory, threads, device, and the names of files, whose contents are compared instead.
#pragma once

#include <span>

#include "src/parallel/team.h"
#include "src/render/camera/camera.h"
#include "tools/scene/open_scene.h"

namespace CLI {
class App;
}

namespace sluice {

// The program's version, the command and its options. All ranks call these, and all throw Error,
// the same line, when one of them differs.
void expectSameCommand(Team& team, const CLI::App& app);
// The volume's step that the scene was opened for, its transfer function, the cameras, and for a
// cut through levels of resolution the blocks that each picture with these options is drawn from.
void expectSameScene(Team& team, Scene& scene, std::span<const Camera> cameras,
                     const FrameOptions& options);
// The same for another step of the scene's series.
void expectSameStep(Team& team, const Scene& scene, const TimeStep& step);

}  // namespace sluice

// The options that all ranks of a command must share, and checks of them
// (src/parallel/agreement.h).
//
// Options that determine the picture must be the same. Options of a rank's own machine may differ:
// memory, threads, device, and the names of files, whose contents are compared instead. In a scene
// of several channels, or with a second volume, each of them is compared.
#pragma once

#include <span>
#include <vector>

#include "src/parallel/communication/team.h"
#include "src/render/camera/camera.h"
#include "tools/scene/open_scene.h"

namespace CLI {
class App;
}

namespace sluice {

// The program's version, the command and its options. All ranks call these, and all throw Error,
// the same line, when one of them differs.
void expectSameCommand(Team& team, const CLI::App& app);
// The step of each volume that the scene was opened for, its transfer function, the cameras, and
// for a cut through levels of resolution the blocks that each picture with these options is drawn
// from.
void expectSameScene(Team& team, Scene& scene, std::span<const Camera> cameras,
                     const FrameOptions& options);
// The same for another step of the scene's series, of each layer.
void expectSameStep(Team& team, const Scene& scene, const std::vector<TimeStep>& steps);

}  // namespace sluice

// Options that were given for nothing: another option, or the volume, leaves them without any
// effect on the picture. A table has a rule for each reason; a command prints a line for each
// option.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "src/library/drawing/scene/channel_shares.h"
#include "src/library/requests.h"
#include "src/render/camera/frame_options.h"
#include "tools/command_line/option_group.h"
#include "tools/options/arguments.h"

namespace sluice {

// The long names of the options that the command line gives: "--fov". To be taken before a saved
// view is applied, since its options are kept for the pictures in which they count.
std::set<std::string> givenOptions(const CLI::App& app);

// The facts that decide. A command that does not know one leaves it as it is: nothing is idle then.
struct PictureFacts {
  const LookArguments& look;
  const FrameOptions& frame;
  const CullingArguments& culling;
  const MachineOptions& machine;
  bool is_drawn = true;  // not only planned
  bool is_film = true;
  bool is_lit = true;
  bool integrates = true;  // Scene::integrates()
  bool shows_labels = false;
  size_t layers = 2;  // channels, and the volume of --over
  bool is_blended = false;
  int64_t time_steps = 2;
  size_t levels = 2;  // of resolution, that pictures are drawn from
};

// The facts that the options and the layers' volumes tell; the others are as for a film that is
// drawn.
PictureFacts pictureFacts(const LookArguments& look, const FrameOptions& frame,
                          const CullingArguments& culling, const MachineOptions& machine,
                          const std::vector<LayerLook>& layers);

// "--fov changes nothing with an orthographic camera; ...", a line for each idle option.
std::vector<std::string> idleOptions(const std::set<std::string>& given, const PictureFacts& facts);

}  // namespace sluice

// The requests of a turn around a volume, from plans alone: those that the renderer makes of the
// texture cache of each channel.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "src/library/requests.h"
#include "src/render/camera/frame_options.h"
#include "tools/command_line/outputs.h"
#include "tools/options/arguments.h"
#include "tools/scene/replay.h"

namespace sluice {

struct TurnArguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  ResourceArguments resources;
  FitChoice fit;
  int64_t frames = 36;
  bool is_plan_fixed =
      false;  // planned for `fixed_pages` (0: the default) whatever the cache's size
  uint64_t fixed_pages = 0;
  std::set<std::string> given = {};  // options on the command line, to tell of idle ones
};

// `frames` views of a full turn, a source for each channel that they show; the volume is opened and
// indexed here, once `outputs` are none of the files that it is read from. Throws Error.
std::vector<std::unique_ptr<ReplaySource>> openTurn(const TurnArguments& arguments,
                                                    const Outputs& outputs);

}  // namespace sluice

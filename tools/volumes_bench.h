// What benches over any set of volumes are asked.
#pragma once

#include <string>
#include <vector>

#include "tools/options.h"

namespace sluice {

struct VolumesBench {
  std::vector<std::string> volumes;  // FILE or FILE@THRESHOLD
  LookArguments look;                // threshold of those without one
  FrameOptions frame;
  ResourceArguments resources;
  OpenOptions open;
  int64_t time = 0;
  int frames = 9;
};

}  // namespace sluice

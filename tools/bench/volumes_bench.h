// Options of benches over any set of volumes, and code that they share.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/render/camera/frame_options.h"
#include "tools/options/arguments.h"

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

// "bonsai.nii.gz@40" -> the file and 40; a file without one keeps `threshold`.
std::pair<std::string, std::optional<double>> splitThreshold(const std::string& word,
                                                             std::optional<double> threshold);
// Requires: values not empty.
double median(std::vector<double> values);

}  // namespace sluice

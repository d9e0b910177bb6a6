// sluice bench algorithms: Tong's Table 1 for any set of volumes, and beside it what the texture
// cache moved.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "tools/options.h"

namespace sluice {

struct AlgorithmsBench {
  std::vector<std::string> volumes;  // FILE or FILE@THRESHOLD
  LookArguments look;                // threshold of those without one
  FrameOptions frame;
  ResourceArguments resources;
  OpenOptions open;
  int frames = 9;
};

// {"rows": [...]}: one object a volume, the names of the interface. Throws Error.
nlohmann::json benchAlgorithms(const AlgorithmsBench& bench);
void printAlgorithms(const nlohmann::json& report);

// "bonsai.nii.gz@40" -> the file and 40; a file without one keeps `threshold`.
std::pair<std::string, std::optional<double>> splitThreshold(const std::string& word,
                                                             std::optional<double> threshold);

}  // namespace sluice

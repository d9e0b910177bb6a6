// How compressed volumes of one stream are decoded (decoded_file.h). Plain data.
#pragma once

#include <functional>
#include <string>

#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

struct DecodeOptions {
  std::string folder = {};  // folder of the temporary file; empty: /var/tmp, or /tmp
  // Returns the watch that is told of a file's bytes as they are decoded; null: nobody.
  std::function<ProgressWatch(const std::string& file)> watch = {};
  StopToken stop = {};  // ends decoding by Interrupted
};

}  // namespace sluice

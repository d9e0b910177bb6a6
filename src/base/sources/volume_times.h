// The times of a volume's steps, as its file tells them.
#pragma once

#include <optional>
#include <string>

#include "src/base/sources/volume_source.h"

namespace sluice {

// A plain value; the default is what is assumed of a file that tells nothing.
struct TimeAxis {
  double step = 1, start = 0;  // from one step to the next, above 0; and the time of the first
  std::string unit = {};       // "second"; empty: not known
  friend bool operator==(const TimeAxis&, const TimeAxis&) = default;
};

// A VolumeSource implements this too if its file may tell times; see timesOf().
class TimedSource {
 public:
  virtual ~TimedSource() = default;
  // nullopt: the file does not tell them, or has one step. Constant after construction, any thread.
  virtual std::optional<TimeAxis> times() const = 0;
};

// The times of a source's steps; nullopt: its file does not tell them.
inline std::optional<TimeAxis> timesOf(const VolumeSource& source) {
  const auto* timed = dynamic_cast<const TimedSource*>(&source);
  return timed == nullptr ? std::nullopt : timed->times();
}

}  // namespace sluice

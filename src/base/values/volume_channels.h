// The names of a volume's channels, as its file gives them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "src/base/values/volume_source.h"

namespace sluice {

// A VolumeSource implements this too if its file may name channels; see channelNames().
class ChanneledSource {
 public:
  virtual ~ChanneledSource() = default;
  // The names from channel 0 on; perhaps fewer than there are channels, and some of them empty.
  // Constant after construction, any thread.
  virtual std::span<const std::string> channelNames() const = 0;
};

// The names of a source's channels; empty if it names none.
inline std::span<const std::string> channelNames(const VolumeSource& source) {
  const auto* channeled = dynamic_cast<const ChanneledSource*>(&source);
  return channeled == nullptr ? std::span<const std::string>() : channeled->channelNames();
}

}  // namespace sluice

// The names of the channels of a volume, as its file says them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "src/base/volume_source.h"

namespace sluice {

// What a VolumeSource also is if its file may name channels; found by channelNames().
class ChanneledSource {
 public:
  virtual ~ChanneledSource() = default;
  // From channel 0 on; perhaps fewer than there are channels, and some of them empty. Constant
  // after construction, any thread.
  virtual std::span<const std::string> channelNames() const = 0;
};

// Those of a source; none if it names none.
inline std::span<const std::string> channelNames(const VolumeSource& source) {
  const auto* channeled = dynamic_cast<const ChanneledSource*>(&source);
  return channeled == nullptr ? std::span<const std::string>() : channeled->channelNames();
}

}  // namespace sluice

// The channels of a volume, as its file describes them: their names, and how they are to be shown.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

// How a channel is to be shown. A plain value; the default says nothing.
struct StoredLook {
  std::optional<std::array<double, 3>> color = {};  // red, green, blue, 0 to 1
  std::optional<ValueRange> window = {};            // stored values that show dark and bright
  std::optional<ValueRange> limits = {};            // of windows that viewers let users choose
  bool is_active = true;                            // shown at first
  bool is_inverted = false;                         // low values are to be bright, high ones dark
  friend bool operator==(const StoredLook&, const StoredLook&) = default;
};

// A VolumeSource implements this too if its file may describe channels; see channelNames() and
// channelLooks().
class ChanneledSource {
 public:
  virtual ~ChanneledSource() = default;
  // The names from channel 0 on; perhaps fewer than there are channels, and some of them empty.
  // Constant after construction, any thread.
  virtual std::span<const std::string> channelNames() const = 0;
  // The looks in the same way; empty if the file says nothing of how channels look.
  virtual std::span<const StoredLook> channelLooks() const { return {}; }
};

// The names of a source's channels; empty if it names none.
inline std::span<const std::string> channelNames(const VolumeSource& source) {
  const auto* channeled = dynamic_cast<const ChanneledSource*>(&source);
  return channeled == nullptr ? std::span<const std::string>() : channeled->channelNames();
}

// The looks of a source's channels; empty if its file gives none.
inline std::span<const StoredLook> channelLooks(const VolumeSource& source) {
  const auto* channeled = dynamic_cast<const ChanneledSource*>(&source);
  return channeled == nullptr ? std::span<const StoredLook>() : channeled->channelLooks();
}

}  // namespace sluice

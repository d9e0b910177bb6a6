#include "io/files/channel_note.h"

#include <fmt/format.h>

namespace sluice {

void noteChannels(const std::string& path, const std::vector<std::string>& names,
                  VolumeLayout& layout) {
  if (layout.channels < 2) return;
  const auto shown = [&](int64_t channel) {
    const auto at = static_cast<size_t>(channel);
    return at < names.size() && !names[at].empty() ? fmt::format("{} ({})", channel, names[at])
                                                   : fmt::format("{}", channel);
  };
  constexpr int64_t kMostNamed = 8;
  std::string others;
  for (int64_t c = 1; c < layout.channels && c < kMostNamed; ++c)
    others += fmt::format("{}{}", others.empty() ? "" : ", ", shown(c));
  if (layout.channels > kMostNamed) others += fmt::format(", ... {}", layout.channels - 1);
  layout.notes.push_back(fmt::format("{}: channel {} of {} is read; --channel takes {}", path,
                                     shown(0), layout.channels, others));
}

}  // namespace sluice

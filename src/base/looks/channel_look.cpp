#include "src/base/looks/channel_look.h"

#include <fmt/format.h>

#include <span>
#include <vector>

#include "src/base/files/number_text.h"
#include "src/base/values/text_parts.h"

namespace sluice {
namespace {

// "400:3000".
std::optional<ValueRange> rangeOf(std::string_view text) {
  const size_t colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  const auto lo = numberOf(text.substr(0, colon)), hi = numberOf(text.substr(colon + 1));
  if (!lo || !hi || *lo == *hi) return std::nullopt;
  return ValueRange{*lo, *hi};
}

}  // namespace

bool isLabelTable(std::string_view map) {
  return map.find_first_of("./") != std::string_view::npos;
}

std::optional<ChannelLook> parseChannelLook(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, ',');
  const std::string_view head = parts.front();
  // The last colon, since names of channels may have some.
  const size_t colon = head.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  ChannelLook look{.channel = std::string(head.substr(0, colon)),
                   .map = std::string(head.substr(colon + 1))};
  for (const std::string_view part : std::span(parts).subspan(1)) {
    const bool is_range = part.find(':') != std::string_view::npos;
    // A range comes before the opacity, and each once.
    if (is_range ? look.range || look.opacity : look.opacity.has_value()) return std::nullopt;
    if (is_range) {
      look.range = rangeOf(part);
      if (!look.range) return std::nullopt;
    } else {
      look.opacity = numberOf(part);
      if (!look.opacity || *look.opacity < 0 || *look.opacity > 1) return std::nullopt;
    }
  }
  return look;
}

std::string channelLookText(const ChannelLook& look) {
  std::string text = fmt::format("{}:{}", look.channel, look.map);
  if (look.range) text += fmt::format(",{}:{}", look.range->lo, look.range->hi);
  if (look.opacity) text += fmt::format(",{}", *look.opacity);
  return text;
}

bool isLookOf(const ChannelLook& look, std::string_view id, std::string_view name) {
  return look.channel == id || (!name.empty() && look.channel == name);
}

}  // namespace sluice

#include "src/base/looks/surface_look.h"

#include <fmt/format.h>

#include "src/base/files/number_text.h"
#include "src/base/looks/color_word.h"

namespace sluice {
std::optional<SurfaceLook> parseSurfaceLook(std::string_view text) {
  SurfaceLook look;
  const size_t first = text.find(':');
  const std::optional<double> value = numberOf(text.substr(0, first));
  if (!value) return std::nullopt;
  look.value = *value;
  if (first == std::string_view::npos) return look;
  const size_t second = text.find(':', first + 1);
  const std::optional<double> opacity = numberOf(text.substr(first + 1, second - first - 1));
  if (!opacity || *opacity < 0 || *opacity > 1) return std::nullopt;
  look.opacity = *opacity;
  if (second == std::string_view::npos) return look;
  look.color = text.substr(second + 1);
  if (!isColorWord(look.color)) return std::nullopt;
  return look;
}

std::string surfaceLookText(const SurfaceLook& look) {
  if (!look.color.empty()) return fmt::format("{}:{}:{}", look.value, look.opacity, look.color);
  if (look.opacity != 1) return fmt::format("{}:{}", look.value, look.opacity);
  return fmt::format("{}", look.value);
}

}  // namespace sluice

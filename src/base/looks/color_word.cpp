#include "src/base/looks/color_word.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace sluice {

std::string colorWord(std::span<const double> rgb) {
  std::string word;
  for (const double part : rgb)
    word += fmt::format("{:02x}", std::lround(std::clamp(part, 0.0, 1.0) * 255));
  return word;
}

std::optional<Vec3d> hexColor(std::string_view text) {
  if (text.starts_with('#')) text.remove_prefix(1);
  unsigned rgb = 0;
  const char* end = text.data() + text.size();
  const auto [read, status] = std::from_chars(text.data(), end, rgb, 16);
  // from_chars() stops at the first wrong character, so that the end tells whether it read all.
  if (text.size() != 6 || status != std::errc() || read != end) return std::nullopt;
  return Vec3d{static_cast<double>(rgb >> 16), static_cast<double>(rgb >> 8 & 255),
               static_cast<double>(rgb & 255)} /
         255.0;
}

}  // namespace sluice

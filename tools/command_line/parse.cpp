#include "tools/command_line/parse.h"

#include <charconv>
#include <cmath>

#include "src/base/looks/color_word.h"
#include "src/classify/transfer/color_maps.h"

namespace sluice {

std::optional<std::vector<double>> parseNumbers(const std::string& text, size_t count) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* end = at + text.size();
  while (at != end) {
    double number = 0;
    const auto [next, status] = std::from_chars(at, end, number);
    if (status != std::errc() || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    at = next;
    if (at == end) break;
    if (*at != ',' && *at != 'x') return std::nullopt;
    if (++at == end) return std::nullopt;
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

std::optional<PictureSize> parsePictureSize(const std::string& text) {
  constexpr double kMostSide = 1 << 30;  // far beyond any device, which has a limit of its own
  auto numbers = parseNumbers(text, 2);
  if (!numbers) {
    numbers = parseNumbers(text, 1);
    if (!numbers) return std::nullopt;
    numbers->push_back(numbers->front());
  }
  for (const double n : *numbers)
    if (n < 1 || n > kMostSide || n != std::floor(n)) return std::nullopt;
  return PictureSize{static_cast<int>((*numbers)[0]), static_cast<int>((*numbers)[1])};
}

std::optional<std::array<float, 3>> parseColor(const std::string& text) {
  const std::optional<Vec3d> color = hexColor(text);
  if (!color) return std::nullopt;
  return std::array<float, 3>{static_cast<float>(color->x), static_cast<float>(color->y),
                              static_cast<float>(color->z)};
}

Vec3d asVec3d(const std::vector<double>& n) {
  return {n[0], n[1], n[2]};
}
Vec3i asVec3i(const std::vector<double>& n) {
  return {static_cast<int64_t>(n[0]), static_cast<int64_t>(n[1]), static_cast<int64_t>(n[2])};
}

}  // namespace sluice

#include "src/view/state/editing/transfer_edit.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "src/base/error.h"

namespace sluice {
namespace {

std::optional<std::array<double, 2>> rangeIn(std::string_view options) {
  const std::string word = wordAfter(options, "--range");
  const size_t comma = word.find(',');
  if (comma == std::string::npos) return std::nullopt;
  return std::array{std::strtod(word.c_str(), nullptr),
                    std::strtod(word.c_str() + comma + 1, nullptr)};
}

// The look without options that contradict a ramp.
LookOptions withoutOpacities(LookOptions look) {
  look.threshold.reset();
  look.opacities.clear();
  look.transfer_file.clear();
  look.labels = false;
  return look;
}

}  // namespace

LookOptions withThreshold(LookOptions look, double threshold) {
  // This is asked before the threshold is removed with the other opacities.
  const bool is_ramp = look.threshold.has_value();
  look = withoutOpacities(std::move(look));
  look.threshold = threshold;
  // The range of another kind of look suits its colours. Those of a ramp begin at its threshold,
  // unless the user gives a range.
  if (!is_ramp) look.range.reset();
  return look;
}

std::array<double, 2> colorsOf(const LookOptions& look, std::array<double, 2> range) {
  if (look.range) return *look.range;
  if (look.threshold && *look.threshold < range[1]) range[0] = *look.threshold;
  return range;
}

std::string wordAfter(std::string_view options, std::string_view option) {
  for (size_t at = 0; at < options.size();) {
    const size_t end = std::min(options.find(' ', at), options.size());
    if (options.substr(at, end - at) == option) {
      const size_t from = std::min(end + 1, options.size());
      // shellWord() quotes words in this way.
      if (from < options.size() && options[from] == '\'') {
        const size_t close = std::min(options.find('\'', from + 1), options.size());
        return std::string(options.substr(from + 1, close - from - 1));
      }
      return std::string(
          options.substr(from, std::min(options.find(' ', from), options.size()) - from));
    }
    at = end + 1;
  }
  return {};
}

LookOptions byPoints(const LookOptions& look, const ShownLook& shown, std::array<double, 2> range) {
  if (!look.opacities.empty()) return look;
  LookOptions next = withoutOpacities(look);
  next.opacity.reset();
  for (const ShownLook::Opacity& point : shown.opacities)
    next.opacities.push_back({point.value, point.opacity});
  // The editor draws lines between points, so it needs two.
  while (next.opacities.size() < 2)
    next.opacities.push_back(next.opacities.empty()
                                 ? LookOptions::Opacity{range[0], 0}
                                 : LookOptions::Opacity{std::max(range[1], next.opacities[0].value),
                                                        next.opacities[0].opacity});
  // Opacities may stand over a file's colours.
  next.transfer_file = look.transfer_file;
  if (!next.transfer_file.empty()) return next;  // its colours stay
  if (next.map.empty()) next.map = wordAfter(shown.options, "--map");
  const std::array<double, 2> colors = rangeIn(shown.options).value_or(colorsOf(look, range));
  next.range = colors;
  if (colors[0] == colors[1]) next.range = std::array{colors[0], colors[0] + 1};
  return next;
}

double heightOf(double opacity) {
  // Opacities of volumes lie close to 0, so the plot shows their cube root.
  return std::cbrt(std::clamp(opacity, 0.0, 1.0));
}
double opacityAtHeight(double height) {
  const double h = std::clamp(height, 0.0, 1.0);
  return h * h * h;
}

std::optional<size_t> pointAt(const OpacityPoints& points, std::array<double, 2> range,
                              double share, double height, double reach_share,
                              double reach_height) {
  const double span = range[1] > range[0] ? range[1] - range[0] : 1;
  std::optional<size_t> nearest;
  double least = 1;
  for (size_t i = 0; i < points.size(); ++i) {
    const double across = ((points[i].value - range[0]) / span - share) / reach_share;
    const double up = (heightOf(points[i].opacity) - height) / reach_height;
    // The distance is measured in reaches, so that 1 is the edge of an ellipse around each point.
    const double far = across * across + up * up;
    if (far > least) continue;
    least = far;
    nearest = i;
  }
  return nearest;
}

size_t addPoint(OpacityPoints& points, double value, double opacity) {
  const auto at =
      // Behind points of the same value, so that a step keeps its order.
      std::upper_bound(points.begin(), points.end(), value,
                       [](double v, const LookOptions::Opacity& point) { return v < point.value; });
  const auto put = points.insert(at, {value, std::clamp(opacity, 0.0, 1.0)});
  return static_cast<size_t>(put - points.begin());
}

void movePoint(OpacityPoints& points, size_t index, double value, double opacity) {
  SLUICE_CHECK_LT(index, points.size());
  // Points stay in ascending order: a drag stops at its neighbours.
  if (index > 0) value = std::max(value, points[index - 1].value);
  if (index + 1 < points.size()) value = std::min(value, points[index + 1].value);
  points[index] = {value, std::clamp(opacity, 0.0, 1.0)};
}

bool removePoint(OpacityPoints& points, size_t index) {
  // A look of one point would be opaque or empty everywhere.
  if (points.size() <= 2 || index >= points.size()) return false;
  points.erase(points.begin() + static_cast<std::ptrdiff_t>(index));
  return true;
}

std::array<double, 2> windowDragged(std::array<double, 2> range, double dx, double dy,
                                    std::array<double, 2> all) {
  const double span = all[1] > all[0] ? all[1] - all[0] : 1;
  const double level = (range[0] + range[1]) / 2 + dy * span;
  const bool turned = range[1] < range[0];
  double window = std::abs(range[1] - range[0]) + dx * span;
  // The window never becomes empty or turns round.
  window = std::clamp(window, span * 1e-4, span * 4);
  const double center = std::clamp(level, all[0] - span, all[1] + span);
  return turned ? std::array{center + window / 2, center - window / 2}
                : std::array{center - window / 2, center + window / 2};
}

}  // namespace sluice

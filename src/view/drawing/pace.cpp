#include "src/view/drawing/pace.h"

#include <algorithm>
#include <array>

namespace sluice {
namespace {

constexpr double kFaster = 0.2;  // the weight of a faster frame in the expected time

// Best first. Below half the size longer steps show as little as the pixels do.
constexpr std::array<Quality, 8> kQualities = {
    {{1, 1}, {0.75, 1}, {0.6, 1.25}, {0.5, 1.5}, {0.375, 2}, {0.25, 2}, {0.1875, 3}, {0.125, 4}}};

// A slower frame counts more, so that the next one keeps its budget. A faster one may be an
// exception.
double mixed(double known, double found) {
  if (known <= 0) return found;
  const double share = found > known ? 0.6 : kFaster;
  return known + share * (found - known);
}

}  // namespace

Pace learned(Pace pace, const DrawnFrame& frame) {
  // A frame for which nothing was drawn says nothing about the cost of pixels.
  if (frame.pixels > 0 && frame.draw_s > 0) {
    pace.pixel_s = mixed(pace.pixel_s, frame.draw_s * frame.step_vox / frame.pixels);
    pace.pixel_convert_s = mixed(pace.pixel_convert_s, frame.convert_s / frame.pixels);
  }
  pace.fixed_s = mixed(pace.fixed_s, frame.other_s);
  return pace;
}

double expectedSeconds(const Pace& pace, const Quality& quality, double pixels, double step_vox) {
  const double pixel_s = pace.pixel_s / (step_vox * quality.step_factor) + pace.pixel_convert_s;
  return pace.fixed_s + pixel_s * pixels * quality.scale * quality.scale;
}

double drawingBudget(double budget_s, double showing_s) {
  // Showing may take longer than the budget allows. A third is left in any case, or there would be
  // no picture.
  return std::max(budget_s / 3, budget_s - showing_s);
}

Quality qualityWithin(const Pace& pace, double pixels, double step_vox, double budget_s,
                      PreviewSteps steps) {
  const auto with = [steps](Quality quality) {
    if (steps == PreviewSteps::kFollowPixels) quality.step_factor = 1 / quality.scale;
    return quality;
  };
  // The first picture of a volume should come soon, and the pace is known after it.
  if (!pace.isKnown()) return with(kQualities[5]);
  for (const Quality& known : kQualities) {
    const Quality quality = with(known);
    if (expectedSeconds(pace, quality, pixels, step_vox) <= budget_s) return quality;
  }
  return with(kQualities.back());
}

}  // namespace sluice

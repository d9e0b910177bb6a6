#include "src/cpu/kernels/color_ramp.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sluice {
namespace {

// The opacity may differ by this share of the greatest one: over a ray of 400 samples, each half
// opaque at the most, by 1/255.
constexpr double kMostError = 2e-5;
// Opacities may differ by this share of themselves too, and so may colours times an opacity: pixels
// that are nearly clear then mix the same colours. An entry that shows nothing shows nothing.
constexpr double kMostShare = 1e-3;
// Ramps of fewer entries are steps.
constexpr size_t kFewestEntries = 16;

struct Entries {
  std::span<const float> rgba;
  size_t count() const { return rgba.size() / 4; }
  double color(size_t entry, size_t c) const { return rgba[4 * entry + c]; }
  double opacity(size_t entry) const { return rgba[4 * entry + 3]; }
};

// The places, in entries, at which the opacity begins to rise and has risen. `first`: the first
// entry that shows something.
struct Rise {
  size_t first;
  double begin, end;
};

std::optional<Rise> riseOf(const Entries& entries, double most) {
  size_t first = 0;
  while (first < entries.count() && entries.opacity(first) == 0) ++first;
  size_t last = first;
  while (last < entries.count() && std::abs(entries.opacity(last)) < std::abs(most)) ++last;
  if (last == entries.count() || last < first + kFewestEntries) return std::nullopt;
  // Both ends lie between entries. Slopes are taken over several: neighbours differ by little more
  // than single precision shows.
  const size_t apart = std::max<size_t>(1, (last - first) / 64);
  const auto slopeFrom = [&](size_t entry) {
    return (entries.opacity(entry + apart) - entries.opacity(entry)) / static_cast<double>(apart);
  };
  const double begin_slope = slopeFrom(first), end_slope = slopeFrom(last - 1 - apart);
  if (begin_slope * most <= 0 || end_slope * most <= 0) return std::nullopt;
  const double end = static_cast<double>(last - 1) + (most - entries.opacity(last - 1)) / end_slope;
  // The entry before the first one shows nothing.
  const double risen = entries.opacity(first) / begin_slope;
  return Rise{first, static_cast<double>(first) - (first > 0 ? std::min(risen, 1.0) : risen),
              std::min(end, static_cast<double>(last))};
}

double valueAt(const std::array<double, 3>& curve, double t) {
  return t * (curve[0] + t * (curve[1] + t * curve[2]));
}

// The curve through the middle and the end of the rise, and through a place before both.
std::array<double, 3> curveThrough(const Entries& entries, const Rise& rise) {
  std::array<double, 3> t, over;  // opacity / t
  const double length = rise.end - rise.begin;
  for (size_t i = 0; i < t.size(); ++i) {
    const double share = static_cast<double>(i + 1) / 3;
    const auto entry = static_cast<size_t>(std::max(0.0, std::floor(rise.begin + share * length)));
    t[i] = (static_cast<double>(entry) - rise.begin) / length;
    over[i] = entries.opacity(entry) / t[i];
  }
  // Newton's divided differences.
  const double first = (over[1] - over[0]) / (t[1] - t[0]);
  const double second = ((over[2] - over[1]) / (t[2] - t[1]) - first) / (t[2] - t[0]);
  return {over[0] - first * t[0] + second * t[0] * t[1], first - second * (t[0] + t[1]), second};
}

// Whether all entries that show something have this colour, premultiplied by their opacity or not.
bool haveColor(const Entries& entries, const std::array<double, 3>& rgb, bool is_premultiplied) {
  for (size_t i = 0; i < entries.count(); ++i) {
    if (entries.opacity(i) == 0) continue;
    const double factor = is_premultiplied ? entries.opacity(i) : 1;
    for (size_t c = 0; c < 3; ++c)
      if (std::abs(entries.color(i, c) - rgb[c] * factor) > kMostShare * std::abs(factor))
        return false;
  }
  return true;
}

}  // namespace

std::optional<ColorRamp> colorRamp(std::span<const float> rgba) {
  const Entries entries{rgba};
  size_t most_at = 0;
  for (size_t i = 0; i < entries.count(); ++i)
    if (std::abs(entries.opacity(i)) > std::abs(entries.opacity(most_at))) most_at = i;
  if (entries.count() == 0 || entries.opacity(most_at) == 0) return std::nullopt;
  const double most = entries.opacity(most_at);
  const std::optional<Rise> rise = riseOf(entries, most);
  if (!rise) return std::nullopt;
  const std::array<double, 3> curve = curveThrough(entries, *rise);
  const double scale = 1 / (rise->end - rise->begin);
  const double first = static_cast<double>(rise->first);
  const double offset = (first - rise->begin) * scale;
  for (size_t i = 0; i < entries.count(); ++i) {
    const double t = std::clamp((static_cast<double>(i) - first) * scale + offset, 0.0, 1.0);
    const double error =
        std::min(kMostError * std::abs(most), kMostShare * std::abs(entries.opacity(i)));
    // Written so that no curve passes that is no number.
    if (!(std::abs(valueAt(curve, t) - entries.opacity(i)) <= error)) return std::nullopt;
  }
  ColorRamp ramp{static_cast<float>(first),
                 static_cast<float>(scale),
                 static_cast<float>(offset),
                 {},
                 {},
                 false};
  for (size_t i = 0; i < curve.size(); ++i) ramp.curve[i] = static_cast<float>(curve[i]);
  // First the stricter one: small products all look like black.
  for (const bool is_premultiplied : {true, false}) {
    std::array<double, 3> rgb;
    for (size_t c = 0; c < 3; ++c) {
      rgb[c] = entries.color(most_at, c) / (is_premultiplied ? most : 1);
      ramp.rgb[c] = static_cast<float>(rgb[c]);
    }
    ramp.is_premultiplied = is_premultiplied;
    if (haveColor(entries, rgb, is_premultiplied)) return ramp;
  }
  return std::nullopt;
}

}  // namespace sluice

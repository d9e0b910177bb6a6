#include "src/device/shading/look_up_texels.h"

#include "src/device/pictures/depth_code.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sluice {
namespace {

// Entries over which a sample's part fades at an end of the visible values, see LookUp.
constexpr size_t kFadeEntries = 3;
// Extremes of pixels that see nothing are no less.
constexpr float kNothingSeen = 2e38F;

// Modes other than composite: the part, 0 to 1, that a sample of each entry takes, as its alpha.
void setParts(std::vector<float>& rgba) {
  const size_t entries = rgba.size() / 4;
  std::vector<size_t> from_invisible(entries);
  // Values beyond the ends of the table look like its ends, so that nothing fades there.
  size_t distance = kFadeEntries;
  const auto walk = [&](size_t entry) {
    distance = rgba[4 * entry + 3] > 0 ? std::min(distance + 1, kFadeEntries) : 0;
    return distance;
  };
  for (size_t i = 0; i < entries; ++i) from_invisible[i] = walk(i);
  distance = kFadeEntries;
  for (size_t i = entries; i-- > 0;) from_invisible[i] = std::min(from_invisible[i], walk(i));
  for (size_t i = 0; i < entries; ++i)
    rgba[4 * i + 3] = static_cast<float>(from_invisible[i]) / static_cast<float>(kFadeEntries);
}

}  // namespace

LookUpKey lookUpKey(const FrameSetup& setup) {
  return {setup.look_up, setup.mode, setup.projection, setup.slice_length, setup.integrates};
}

std::vector<float> lookUpTexels(const LookUpKey& key) {
  std::vector<float> texels = key.look_up->rgba;
  if (!traitsOf(key.mode).has_colors) {
    setParts(texels);
    return texels;
  }
  // A factor is for the opacity as it is: the shader does the rest.
  if (!key.look_up->magnitudes.empty()) return texels;
  const bool perspective = key.projection == Projection::kPerspective;
  const double length = key.slice_length;
  for (size_t i = 0; i < texels.size(); i += 4) {
    const double opacity = texels[i + 3];
    if (perspective) {
      // An opaque entry stays opaque at any length.
      texels[i + 3] = static_cast<float>(opacity < 1 ? std::log2(1 - opacity) * length : -1e4);
      continue;
    }
    // Most tables have many entries of no opacity, and most steps are the length of a voxel.
    const double corrected =
        opacity > 0 ? 1 - (length == 1 ? 1 - opacity : std::pow(1 - opacity, length)) : 0;
    for (size_t channel = 0; channel < 3; ++channel)
      texels[i + channel] = static_cast<float>(texels[i + channel] * corrected);
    texels[i + 3] = static_cast<float>(corrected);
  }
  return texels;
}

bool showsOpacities(const LookUp& look_up) {
  for (size_t i = 3; i < look_up.rgba.size(); i += 4)
    if (look_up.rgba[i] > 0) return true;
  return false;
}

ShownValues shownValues(const LookUp& look_up) {
  const auto entries = static_cast<int>(look_up.rgba.size() / 4);
  const ShownValues all(look_up.device_range, entries, [](int) { return true; });
  std::vector<int> of_surfaces;
  for (const SurfaceLevel& surface : look_up.surfaces)
    of_surfaces.push_back(all.entryOf(surface.level));
  return {
      look_up.device_range, entries,
      [&](int entry) {
        return look_up.rgba[4 * static_cast<size_t>(entry) + 3] > 0 ||
               (!of_surfaces.empty() && std::ranges::find(of_surfaces, entry) != of_surfaces.end());
      },
      ShownValues::reachOf(look_up.labels, look_up.device_range, entries)};
}

std::array<double, 2> visibleValues(const LookUp& look_up) {
  const std::vector<ShownValues::Interval> intervals = shownValues(look_up).intervals();
  constexpr double kAll = std::numeric_limits<float>::max();
  if (intervals.empty()) return {kAll, -kAll};
  const ValueRange range = look_up.device_range;
  const int last = static_cast<int>(look_up.rgba.size() / 4) - 1;
  const double entry = (range.hi - range.lo) / std::max(1, last);
  // An entry more is for rounding, see the header.
  const int least = intervals.front().first - 1, greatest = intervals.back().last + 1;
  return {least < 0 ? -kAll : range.lo + least * entry,
          greatest > last ? kAll : range.lo + greatest * entry};
}

void scaleValues(const FrameSetup& setup, double device_unit, std::vector<float>& rgba) {
  const ModeTraits& traits = traitsOf(setup.mode);
  // Places in a window, or codes of them.
  if (traits.combining == Combining::kAttenuated || traits.codes_depth) return;
  for (size_t i = 0; i < rgba.size(); i += 4)
    // Numbers that mean that nothing is seen must stay beyond the limit.
    if (std::abs(rgba[i]) < kNothingSeen) rgba[i] *= static_cast<float>(device_unit);
}

namespace {

void resolveDepths(const FrameSetup& setup, std::span<float> rgba) {
  for (size_t i = 0; i < rgba.size(); i += 4) {
    const double code = rgba[i];
    // A code below 0 tells that nothing was seen.
    const bool seen = code >= 0;
    const float part = seen ? std::min(rgba[i + 1], 1.0F) : 0;
    const Vec3d rgb = seen ? depthColor(setup, depthOfCode(code)) * placeOfCode(code) : Vec3d{};
    for (int c = 0; c < 3; ++c)
      rgba[i + static_cast<size_t>(c)] = static_cast<float>(rgb[c]) * part;
    rgba[i + 3] = part;
  }
}

}  // namespace

void resolveMode(const FrameSetup& setup, double device_unit, std::span<float> rgba) {
  if (traitsOf(setup.mode).codes_depth) {
    resolveDepths(setup, rgba);
    return;
  }
  const auto& table = setup.look_up->rgba;
  const size_t entries = table.size() / 4;
  const ValueRange range = setup.look_up->device_range;
  // All values of a volume of one value have the first entry.
  const double per_device =
      range.hi > range.lo ? static_cast<double>(entries - 1) / (range.hi - range.lo) : 0;
  const Combining combining = traitsOf(setup.mode).combining;
  const bool average = combining == Combining::kSum;
  const bool attenuated = combining == Combining::kAttenuated;
  const size_t share = attenuated ? 2 : 1;
  for (size_t i = 0; i < rgba.size(); i += 4) {
    const bool seen =
        average || attenuated ? rgba[i + share] > 0 : std::abs(rgba[i]) < kNothingSeen;
    double device = seen ? rgba[i] * device_unit : 0;
    if (seen && average) device /= rgba[i + 1];
    // The number is a place in the window already, and not a value.
    if (attenuated) device = std::lerp(setup.window[0], setup.window[1], double{rgba[i]});
    // A minimum keeps 1 - the share, since its numbers are combined by taking the least.
    const float part = !seen                            ? 0
                       : combining == Combining::kLeast ? 1 - rgba[i + share]
                                                        : std::min(rgba[i + share], 1.0F);
    const double at =
        std::clamp((device - range.lo) * per_device + 0.5, 0.0, static_cast<double>(entries - 1));
    const float* entry = &table[4 * static_cast<size_t>(at)];
    for (size_t channel = 0; channel < 3; ++channel) rgba[i + channel] = entry[channel] * part;
    rgba[i + 3] = part;
  }
}

}  // namespace sluice

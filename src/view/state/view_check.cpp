#include "src/view/state/view_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "src/base/error.h"
#include "src/base/values/vec.h"

namespace sluice {
namespace {

// The limits of the options of the same names (tools/options/view_options.cpp), so that the
// printed command accepts every number that the window accepts.
constexpr double kMostDegrees = 36000, kZoomLimit = 1e6, kMostFov = 179, kMostStep = 1e6;
constexpr double kWorld = 1e15, kMostGradient = 1e6;
constexpr size_t kMostPlanes = 6;
constexpr int64_t kMostVoxels = int64_t{1} << 40;  // along an axis, as of --crop

using Triple = std::array<double, 3>;

Vec3d vecOf(const Triple& a) {
  return {a[0], a[1], a[2]};
}

template <class Range>
bool areFinite(const Range& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::isfinite(n); });
}

// Keeps the first fault that it is told of.
class Findings {
 public:
  template <class Found>
  void require(bool is_right, const std::string& field, const std::string& expected,
               const Found& found) {
    if (!is_right && !first_) first_ = ViewFault{field, expected, fmt::format("{}", found)};
  }
  // Requires a number in (0, most].
  void above0(const std::string& field, double number, double most) {
    require(number > 0 && number <= most, field, fmt::format("a number above 0, up to {}", most),
            number);
  }
  void finite(const std::string& field, double number) {
    require(std::isfinite(number), field, "a finite number", number);
  }
  void share(const std::string& field, double number) {
    require(number >= 0 && number <= 1, field, "a number in 0..1", number);
  }
  void degrees(const std::string& field, double number) {
    require(std::abs(number) <= kMostDegrees, field,
            fmt::format("degrees from {} to {}", -kMostDegrees, kMostDegrees), number);
  }
  void world(const std::string& field, const Triple& place) {
    require(std::all_of(place.begin(), place.end(), [](double n) { return std::abs(n) <= kWorld; }),
            field, fmt::format("three numbers from {} to {}", -kWorld, kWorld), place);
  }
  const std::optional<ViewFault>& first() const { return first_; }

 private:
  std::optional<ViewFault> first_;
};

void checkCamera(Findings& findings, const ViewOptions& view) {
  findings.above0("/camera/zoom", view.zoom, kZoomLimit);
  findings.above0("/camera/fov", view.field_of_view_deg, kMostFov);
  findings.degrees("/camera/azimuth", view.azimuth_deg);
  findings.degrees("/camera/elevation", view.elevation_deg);
  if (view.up) {
    findings.world("/camera/up", *view.up);
    findings.require(length(vecOf(*view.up)) > 0, "/camera/up", "a direction with a length",
                     *view.up);
  }
  if (!view.look_at) return;
  const auto& [eye, target] = *view.look_at;
  findings.world("/camera/eye", eye);
  findings.world("/camera/target", target);
  const Vec3d back = vecOf(eye) - vecOf(target);
  findings.require(length(back) > 0, "/camera/eye", "an eye apart from its target", eye);
  if (!view.up) return;
  const Vec3d up = vecOf(*view.up);
  findings.require(length(cross(back, up)) > 1e-9 * length(back) * length(up), "/camera/up",
                   "a direction across the view", *view.up);
}

void checkLook(Findings& findings, const LookOptions& look) {
  if (look.threshold) findings.finite("/look/threshold", *look.threshold);
  if (look.opacity) findings.share("/look/opacity", *look.opacity);
  for (size_t i = 0; i < look.opacities.size(); ++i) {
    const auto& [value, opacity] = look.opacities[i];
    const std::string field = fmt::format("/look/opacities/{}", i);
    findings.finite(field + "/0", value);
    findings.share(field + "/1", opacity);
    findings.require(i == 0 || value >= look.opacities[i - 1].value, field, "values that ascend",
                     value);
  }
  if (look.range) {
    findings.require(areFinite(*look.range) && (*look.range)[0] != (*look.range)[1], "/look/range",
                     "two different finite numbers", *look.range);
  }
  if (look.full_gradient)
    findings.above0("/look/full_gradient", *look.full_gradient, kMostGradient);
}

void checkCuts(Findings& findings, const ViewState& state) {
  if (state.crop) {
    const auto& [lo, hi] = *state.crop;
    for (size_t a = 0; a < 3; ++a)
      findings.require(
          lo[a] >= 0 && lo[a] <= kMostVoxels && hi[a] >= lo[a] + 2 && hi[a] <= kMostVoxels, "/crop",
          "voxels from 0 to 2^40, each upper one at least 2 above the lower",
          fmt::format("{} to {}", lo, hi));
  }
  findings.require(state.clip_planes.size() <= kMostPlanes, "/clip",
                   fmt::format("at most {} planes", kMostPlanes), state.clip_planes.size());
  for (size_t i = 0; i < state.clip_planes.size(); ++i) {
    const PictureOptions::Plane& plane = state.clip_planes[i];
    const std::string field = fmt::format("/clip/{}", i);
    findings.world(field, plane.normal);
    findings.require(std::abs(plane.offset) <= kWorld, field + "/3",
                     fmt::format("a number from {} to {}", -kWorld, kWorld), plane.offset);
    findings.require(length(vecOf(plane.normal)) > 0, field, "a normal with a length",
                     plane.normal);
  }
}

}  // namespace

std::optional<ViewFault> faultOf(const ViewState& state) {
  Findings findings;
  checkCamera(findings, state.view);
  checkLook(findings, state.look);
  findings.require(state.time >= 0, "/time", "a time step, counted from 0", state.time);
  if (state.step_vox) findings.above0("/step", *state.step_vox, kMostStep);
  checkCuts(findings, state);
  if (state.background)
    for (size_t c = 0; c < 3; ++c)
      findings.share(fmt::format("/background/{}", c), static_cast<double>((*state.background)[c]));
  for (size_t a = 0; a < 3; ++a)
    findings.require(state.cross[a] >= 0, fmt::format("/cross/{}", a), "a voxel, counted from 0",
                     state.cross[a]);
  return findings.first();
}

std::optional<ViewFault> faultOf(const ViewState& state, const VolumeInfo& volume) {
  Findings findings;
  findings.require(state.time < volume.time_steps, "/time",
                   fmt::format("a time step from 0 to {}", volume.time_steps - 1), state.time);
  const auto& dims = volume.dims;
  for (size_t a = 0; a < 3; ++a) {
    if (state.crop)
      findings.require(state.crop->hi[a] <= dims[a], fmt::format("/crop/{}", a + 3),
                       fmt::format("at most the volume's {} voxels", dims[a]), state.crop->hi[a]);
    findings.require(state.cross[a] < dims[a], fmt::format("/cross/{}", a),
                     fmt::format("a voxel from 0 to {}", dims[a] - 1), state.cross[a]);
  }
  return findings.first();
}

void requireFits(const ViewState& state, const std::optional<ViewPath>& path,
                 const VolumeInfo& volume, const std::string& where) {
  const auto check = [&](const ViewState& each, const std::string& place) {
    const std::optional<ViewFault> fault = faultOf(each, volume);
    if (!fault) return;
    fail(
        "{}: expected {} at {}{}, found {}; correct the file or view the volume that it was saved "
        "for, not {}",
        where, fault->expected, place, fault->field, fault->found, volume.name);
  };
  check(state, {});
  for (size_t i = 0; path && i < path->keys.size(); ++i) check(path->keys[i].state, keyPlace(i));
}

std::string keyPlace(size_t index) {
  return fmt::format("/path/keys/{}", index);
}

}  // namespace sluice

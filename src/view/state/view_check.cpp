#include "src/view/state/view_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <type_traits>

#include "src/base/error.h"
#include "src/base/looks/channel_look.h"
#include "src/base/looks/label_look.h"
#include "src/base/looks/surface_look.h"
#include "src/base/looks/view_limits.h"
#include "src/base/values/vec.h"

namespace sluice {
namespace {

template <class Triple>
Vec3d vecOf(const Triple& a) {
  return {a[0], a[1], a[2]};
}

// Keeps the first fault that it is told of.
class Findings {
 public:
  template <class Found>
  void require(bool is_right, const std::string& field, const std::string& expected,
               const Found& found) {
    if (!is_right && !first_) first_ = ViewFault{field, expected, fmt::format("{}", found)};
  }
  const std::optional<ViewFault>& first() const { return first_; }

 private:
  std::optional<ViewFault> first_;
};

// "degrees from -90 to 90": the numbers of a range, which are called `noun`.
template <class Number>
std::string expectedOf(const NumberRange<Number>& range, std::string_view noun) {
  const auto& [least, most, above_least] = range;
  const NumberRange<Number> all;
  if (above_least) return fmt::format("{} above {}, up to {}", noun, least, most);
  // A range without a lower end has no upper one either, so that only infinity is wrong.
  if (least == all.least) return "a finite number";
  if (most == all.most) return fmt::format("{}, counted from {}", noun, least);
  if (least == 0 && most == 1) return fmt::format("{} in 0..1", noun);
  return fmt::format("{} from {} to {}", noun, least, most);
}

constexpr const char* kExpectedLook =
    "a channel with its colour, range and opacity, such as 0:green,400:3000,0.1";

// The check of one option's values.
// std::visit() calls the operator for the alternative that the option holds. The form tells further
// what the numbers mean.
class Check {
 public:
  Check(const OptionKind& kind, std::string field, Findings& findings)
      : kind_(kind), findings_(findings), field_(std::move(field)) {}

  void operator()(const auto& number)
      const requires std::is_arithmetic_v<std::remove_cvref_t<decltype(number)>> {
    within(field_, kind_.limits, number, kind_.noun);
  }
  void operator()(const std::string& /*text*/) const {}
  void operator()(const OptionReals& n) const {
    if (kind_.form == OptionForm::kRange)
      return require(std::isfinite(n[0]) && std::isfinite(n[1]) && n[0] != n[1], field_,
                     "two different finite numbers", n);
    if (kind_.form == OptionForm::kColor || kind_.form == OptionForm::kAngles ||
        kind_.form == OptionForm::kSpacing)
      return eachWithin(n);
    triple(field_, n);
  }
  void operator()(const OptionWholes& n) const {
    if (kind_.form != OptionForm::kBox) return eachWithin(n);
    for (size_t a = 0; a < 3; ++a)
      require(n[a] >= 0 && n[a] <= kMostAlongAxis && n[a + 3] > n[a] && n[a + 3] <= kMostAlongAxis,
              field_, "voxels from 0 to 2^40, each upper one above the lower",
              fmt::format("[{}, {}, {}] to [{}, {}, {}]", n[0], n[1], n[2], n[3], n[4], n[5]));
  }
  void operator()(const std::vector<std::string>& looks) const {
    if (kind_.form == OptionForm::kSurfaces) return surfaces(looks);
    if (kind_.form == OptionForm::kLabels) return labels(looks);
    require(looks.size() <= kMostChannels, field_,
            fmt::format("looks of at most {} channels", kMostChannels), looks.size());
    for (const std::string& look : looks)
      require(parseChannelLook(look).has_value(), field_, kExpectedLook, look);
  }
  void operator()(const std::vector<OptionReals>& lists) const {
    if (kind_.form == OptionForm::kPlanes)
      require(lists.size() <= kMostAskedPlanes, field_,
              fmt::format("at most {} planes", kMostAskedPlanes), lists.size());
    for (size_t i = 0; i < lists.size(); ++i) {
      const std::string field = fmt::format("{}/{}", field_, i);
      const OptionReals& n = lists[i];
      if (kind_.form == OptionForm::kPoints) {
        within(field + "/0", {}, n[0]);
        within(field + "/1", {0, 1}, n[1]);
        require(i == 0 || n[0] >= lists[i - 1][0], field, "values that ascend", n[0]);
      } else {
        triple(field, {n[0], n[1], n[2]});
        within(field + "/3", kind_.limits, n[3]);
      }
    }
  }

 private:
  void require(bool is_right, const std::string& field, const std::string& expected,
               const auto& found) const {
    findings_.require(is_right, field, expected, found);
  }
  void surfaces(const std::vector<std::string>& looks) const {
    require(looks.size() <= kMostSurfaces, field_,
            fmt::format("at most {} surfaces", kMostSurfaces), looks.size());
    for (const std::string& look : looks)
      require(parseSurfaceLook(look).has_value(), field_,
              "a value with an opacity and a colour, such as 300:0.4:ff8800", look);
  }
  void labels(const std::vector<std::string>& looks) const {
    for (const std::string& look : looks)
      require(parseLabelLook(look).has_value(), field_,
              "a label with a colour and an opacity, such as 3=ff8800:0.4", look);
  }
  void within(const std::string& field, const NumberRange<double>& range, const auto& n,
              std::string_view noun = "a number") const {
    // Whole numbers beyond 2^53 would be rounded in a comparison as doubles.
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(n)>, int64_t>)
      require(wholesIn(range).holds(n), field, expectedOf(wholesIn(range), noun), n);
    else
      require(range.holds(static_cast<double>(n)), field, expectedOf(range, noun), n);
  }
  void eachWithin(const auto& numbers) const {
    for (size_t i = 0; i < numbers.size(); ++i)
      within(fmt::format("{}/{}", field_, i), kind_.limits, numbers[i], kind_.noun);
  }
  void triple(const std::string& field, const OptionReals& n) const {
    require(std::all_of(n.begin(), n.end(), [&](double x) { return kind_.limits.holds(x); }), field,
            expectedOf(kind_.limits, "three numbers"), n);
  }

  const OptionKind& kind_;
  Findings& findings_;
  std::string field_;
};

// Checks of directions, and of the camera's values against each other.
void checkCamera(Findings& findings, const ViewOptions& view) {
  const Vec3d up = view.up ? vecOf(*view.up) : Vec3d{};
  if (view.up)
    findings.require(length(up) > 0, "/camera/up", "a direction with a length", *view.up);
  if (!view.look_at) return;
  const auto& [eye, target] = *view.look_at;
  const Vec3d back = vecOf(eye) - vecOf(target);
  findings.require(length(back) > 0, "/camera/eye", "an eye apart from its target", eye);
  // An up direction along the view leaves the roll open.
  if (view.up)
    findings.require(length(cross(back, up)) > 1e-9 * length(back) * length(up), "/camera/up",
                     "a direction across the view", *view.up);
}

void checkPlanes(Findings& findings, const std::vector<PictureOptions::Plane>& planes) {
  for (size_t i = 0; i < planes.size(); ++i)
    findings.require(length(vecOf(planes[i].normal)) > 0, fmt::format("/clip/{}", i),
                     "a normal with a length", planes[i].normal);
}

}  // namespace

std::optional<ViewFault> faultOf(const OptionKind& kind, const OptionValue& value,
                                 const std::string& field) {
  Findings findings;
  std::visit(Check(kind, field, findings), value);
  return findings.first();
}

std::optional<ViewFault> faultOf(const ViewState& state) {
  Findings findings;
  // The order of the parts is that of the file, and the first fault is the one that is named.
  for (const auto& [part, place] : {std::pair(OptionPart::kCamera, "/camera/"),
                                    {OptionPart::kLook, "/look/"},
                                    {OptionPart::kTop, "/"}}) {
    for (const OptionEntry& entry : optionTable())
      if (entry.part == part)
        if (const auto value = entry.get(state))
          std::visit(Check(entry.kind, std::string(place) + entry.key, findings), *value);
    if (part == OptionPart::kCamera) checkCamera(findings, state.view);
  }
  checkPlanes(findings, state.clip_planes);
  return findings.first();
}

std::optional<ViewFault> faultOf(const ViewState& state, const VolumeInfo& volume) {
  Findings findings;
  findings.require(state.time < volume.time_steps, "/time",
                   fmt::format("a time step from 0 to {}", volume.time_steps - 1), state.time);
  const auto& dims = volume.dims;
  for (size_t a = 0; a < 3; ++a) {
    // The lower corner needs no check of its own, since each upper one is above it
    // (Check).
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

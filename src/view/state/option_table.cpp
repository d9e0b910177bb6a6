#include "src/view/state/option_table.h"

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

namespace sluice {
namespace {

using Look = LookOptions;
using View = ViewOptions;
using Form = OptionForm;
using Words = std::vector<std::string_view>;

constexpr NumberRange<double> kWorld{-1e15, 1e15}, kShare{0, 1};

OptionKind wordOf(Words words) {
  return {.form = Form::kWord, .words = std::move(words)};
}

OptionReals realsOf(const Look::Opacity& point) {
  return {point.value, point.opacity};
}
OptionReals realsOf(const PictureOptions::Plane& plane) {
  return {plane.normal[0], plane.normal[1], plane.normal[2], plane.offset};
}
void assign(Look::Opacity& point, const OptionReals& n) {
  point = {n[0], n[1]};
}
void assign(PictureOptions::Plane& plane, const OptionReals& n) {
  plane = {{n[0], n[1], n[2]}, n[3]};
}

template <class T>
constexpr bool kIsOptional = false;
template <class T>
constexpr bool kIsOptional<std::optional<T>> = true;
template <class T>
concept AnArray = requires(T array) {
  std::tuple_size<T>::value;
};
// The list that holds the numbers of an array.
template <class Array>
using ListOf =
    std::conditional_t<std::is_integral_v<typename Array::value_type>, OptionWholes, OptionReals>;

// The value of a member; nullopt if it is unset or empty.
template <class T>
std::optional<OptionValue> read(const Words& words, const T& held) {
  if constexpr (kIsOptional<T>) {
    return held ? read(words, *held) : std::nullopt;
  } else if constexpr (std::is_enum_v<T>) {
    return std::string(words[static_cast<size_t>(held)]);
  } else if constexpr (std::is_same_v<T, PictureOptions::Box>) {
    return OptionWholes{held.lo[0], held.lo[1], held.lo[2], held.hi[0], held.hi[1], held.hi[2]};
  } else if constexpr (std::is_arithmetic_v<T>) {
    return held;
  } else if constexpr (AnArray<T>) {
    return ListOf<T>(held.begin(), held.end());
  } else if (held.empty()) {
    return std::nullopt;
  } else if constexpr (std::is_same_v<T, std::string>) {
    return held;
  } else {
    std::vector<OptionReals> lists;
    for (const auto& item : held) lists.push_back(realsOf(item));
    return lists;
  }
}

template <class T>
void write(const Words& words, const OptionValue& value, T& held) {
  if constexpr (kIsOptional<T>) {
    write(words, value, held.emplace());
  } else if constexpr (std::is_enum_v<T>) {
    const auto word = std::find(words.begin(), words.end(), std::get<std::string>(value));
    held = static_cast<T>(word - words.begin());
  } else if constexpr (std::is_same_v<T, PictureOptions::Box>) {
    const auto& n = std::get<OptionWholes>(value);
    held = {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
  } else if constexpr (AnArray<T>) {
    const auto& numbers = std::get<ListOf<T>>(value);
    for (size_t i = 0; i < held.size(); ++i)
      held[i] = static_cast<typename T::value_type>(numbers[i]);
  } else if constexpr (
      requires { held.emplace_back().opacity; } || requires { held.emplace_back().offset; }) {
    held.clear();
    for (const OptionReals& n : std::get<std::vector<OptionReals>>(value))
      assign(held.emplace_back(), n);
  } else {
    held = std::get<T>(value);
  }
}

// `held`: the member of a view, constant or not.
template <class Held>
OptionEntry holding(OptionEntry entry, Held held) {
  entry.get = [words = entry.kind.words, held](const ViewState& state) {
    return read(words, held(state));
  };
  entry.set = [words = entry.kind.words, held](ViewState& state, const OptionValue& value) {
    write(words, value, held(state));
  };
  return entry;
}

template <class T>
OptionEntry in(T ViewState::*member, OptionEntry entry) {
  return holding(
      std::move(entry), [=](auto& state) -> auto& { return state.*member; });
}
template <class T>
OptionEntry in(T View::*member, OptionEntry entry) {
  entry.part = OptionPart::kCamera;
  return holding(
      std::move(entry), [=](auto& state) -> auto& { return state.view.*member; });
}
template <class T>
OptionEntry in(T Look::*member, OptionEntry entry) {
  entry.part = OptionPart::kLook;
  return holding(
      std::move(entry), [=](auto& state) -> auto& { return state.look.*member; });
}
// One end of the line of sight.
OptionEntry in(std::array<double, 3> View::LookAt::*member, OptionEntry entry) {
  entry.part = OptionPart::kCamera;
  entry.get = [=](const ViewState& state) -> std::optional<OptionValue> {
    if (!state.view.look_at) return std::nullopt;
    return read({}, *state.view.look_at.*member);
  };
  entry.set = [=](ViewState& state, const OptionValue& value) {
    if (!state.view.look_at) state.view.look_at.emplace();
    write({}, value, *state.view.look_at.*member);
  };
  return entry;
}

bool hasNoPlace(const ViewState& state) {
  return !state.view.look_at;
}
bool hasPerspective(const ViewState& state) {
  return state.view.projection == View::Projection::kPerspective;
}
bool hasLabels(const ViewState& state) {
  return state.look.labels;
}
// Points take the place of all other ways to give opacities, and a file that of a ramp and labels.
bool hasNoPoints(const ViewState& state) {
  return state.look.opacities.empty();
}
bool hasNoFile(const ViewState& state) {
  return hasNoPoints(state) && state.look.transfer_file.empty();
}
bool hasRamp(const ViewState& state) {
  return hasNoFile(state) && !state.look.labels;
}
bool isLater(const ViewState& state) {
  return state.time != 0;
}

std::vector<OptionEntry> makeTable() {
  const OptionKind factor{Form::kNumber, {0, 1e6, true}}, place{Form::kPlace, kWorld};
  const OptionKind degrees{Form::kNumber, {-36000, 36000}, "degrees"};  // a hundred turns
  const Words views{"plain", "front", "back", "left", "right", "top", "bottom", "three-quarter"};
  return {
      in(&View::projection, {"projection", "--projection", 20, wordOf({"ortho", "perspective"})}),
      in(&View::zoom, {"zoom", "--zoom", 28, factor}),
      in(&View::field_of_view_deg,
         {"fov", "--fov", 29, {Form::kNumber, {0, 179, true}}, nullptr, hasPerspective}),
      in(&View::up, {"up", "--up", 27, {Form::kDirection, kWorld}}),
      in(&View::LookAt::eye, {"eye", "--eye", 21, place}),
      in(&View::LookAt::target, {"target", "--target", 22, place}),
      in(&View::from, {"view", "--view", 23, wordOf(views), hasNoPlace}),
      in(&View::azimuth_deg, {"azimuth", "--azimuth", 24, degrees, hasNoPlace}),
      in(&View::elevation_deg, {"elevation", "--elevation", 25, degrees, hasNoPlace}),
      in(&View::fit, {"fit", "--fit", 26, wordOf({"visible", "volume"}), hasNoPlace}),

      in(&Look::mode, {"mode", "--mode", 9, wordOf({"composite", "mip", "minip", "average"})}),
      in(&Look::light, {"light",
                        "--shade",
                        7,
                        {.form = Form::kWord,
                         .words = {"chosen", "on", "off"},
                         .flags = {"", "--shade", "--no-shade"}}}),
      in(&Look::threshold, {"threshold", "--threshold", 3, {}, nullptr, hasRamp}),
      in(&Look::opacity,
         {"opacity", "--opacity", 4, {Form::kNumber, kShare}, nullptr, hasNoPoints}),
      in(&Look::opacities, {"opacities", "--opacities", 1, {Form::kPoints}}),
      in(&Look::transfer_file, {"transfer", "--transfer", 0, {Form::kFile}}),
      in(&Look::labels, {"labels", "--labels", 2, {Form::kFlag}, hasLabels, hasNoFile}),
      in(&Look::map, {"map", "--map", 5, {Form::kText}}),
      in(&Look::range, {"range", "--range", 6, {Form::kRange}}),
      in(&Look::full_gradient,
         {"full_gradient", "--full-gradient", 8, {.limits = factor.limits, .needs = "--modulate"}}),

      in(&ViewState::time,
         {"time", "--time", 40, {Form::kWhole, {0}, "a time step"}, nullptr, isLater}),
      in(&ViewState::step_vox, {"step", "--step", 41, factor}),
      in(&ViewState::crop, {"crop", "--crop", 42, {Form::kBox}}),
      in(&ViewState::clip_planes, {"clip", "--clip", 43, {Form::kPlanes, kWorld}}),
      in(&ViewState::background, {"background", "--background", 44, {Form::kColor, kShare}}),
      in(&ViewState::cross, {"cross", "", 0, {Form::kVoxel, {0}, "a voxel"}}),
      in(&ViewState::shows_slices, {"slices", "", 0, {Form::kFlag}}),
  };
}

}  // namespace

const std::vector<OptionEntry>& optionTable() {
  static const std::vector<OptionEntry> table = makeTable();
  return table;
}

std::optional<OptionValue> savedValue(const OptionEntry& entry, const ViewState& state) {
  if (entry.is_saved != nullptr && !entry.is_saved(state)) return std::nullopt;
  return entry.get(state);
}

}  // namespace sluice

#include "src/view/state/view_path.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "src/base/error.h"
#include "src/base/values/vec.h"
#include "src/options/option_numbers.h"
#include "src/view/state/editing/camera_gestures.h"
#include "src/view/state/files/state_file.h"

namespace sluice {
namespace {

// Real part first.
using Quaternion = std::array<double, 4>;

Vec3d vecOf(const std::array<double, 3>& a) {
  return {a[0], a[1], a[2]};
}
std::array<double, 3> arrayOf(Vec3d v) {
  return {v.x, v.y, v.z};
}

// The rotation of the matrix whose columns are the axes.
Quaternion turningOf(const PlacedAxes& axes) {
  const auto& [r, u, b] = axes;
  Quaternion q{1 + r.x + u.y + b.z, 1 + r.x - u.y - b.z, 1 - r.x + u.y - b.z, 1 - r.x - u.y + b.z};
  // Rounding may make a part slightly negative.
  for (double& part : q) part = std::sqrt(std::max(0.0, part)) / 2;
  // Signs by the largest part, which is at least a half.
  const auto largest = std::max_element(q.begin(), q.end()) - q.begin();
  const double wx = u.z - b.y, wy = b.x - r.z, wz = r.y - u.x;
  const double xy = r.y + u.x, xz = b.x + r.z, yz = u.z + b.y;
  const auto with = [](double size, double sign) { return std::copysign(size, sign); };
  switch (largest) {
    case 0:
      return {q[0], with(q[1], wx), with(q[2], wy), with(q[3], wz)};
    case 1:
      return {with(q[0], wx), q[1], with(q[2], xy), with(q[3], xz)};
    case 2:
      return {with(q[0], wy), with(q[1], xy), q[2], with(q[3], yz)};
    default:
      return {with(q[0], wz), with(q[1], xz), with(q[2], yz), q[3]};
  }
}

// The up and back axes, of any length but 0.
std::pair<Vec3d, Vec3d> upAndBack(Quaternion q) {
  double length = 0;
  for (const double part : q) length += part * part;
  length = std::sqrt(length);
  // Opposite turnings may cancel in the middle. Any axes will do for that one frame.
  if (!(length > 0)) return {{0, 1, 0}, {0, 0, 1}};
  for (double& part : q) part /= length;
  const auto [w, x, y, z] = q;
  return {{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

// Interpolates between two keys at a frame.
class Between {
 public:
  Between(const std::vector<ViewKey>& keys, size_t from, double share)
      : keys_(keys), from_(from), share_(share) {}

  // `of`: a number of a key's state. Smooth; may overshoot.
  template <class Of>
  double smooth(const Of& of) const {
    return hermite(of(from_), of(from_ + 1), slope(of, from_, false), slope(of, from_ + 1, false));
  }
  // Interpolates without ever going beyond the two keys.
  template <class Of>
  double monotone(const Of& of) const {
    const double a = of(from_), b = of(from_ + 1);
    const double found = hermite(a, b, slope(of, from_, true), slope(of, from_ + 1, true));
    return std::clamp(found, std::min(a, b), std::max(a, b));  // whatever rounding does
  }
  size_t from() const { return from_; }
  // The keys that slopes look at: one beyond the two at either side.
  size_t first() const { return from_ > 0 ? from_ - 1 : 0; }
  size_t last() const { return std::min(from_ + 2, keys_.size() - 1); }
  const ViewState& state(size_t key) const { return keys_[key].state; }

  template <class Has>
  bool both(const Has& has) const {
    return has(state(from_)) && has(state(from_ + 1));
  }
  // The number of an option; nullopt if one of the two keys lacks it. `get`: a key's, or nullopt.
  template <class Get>
  std::optional<double> number(const Get& get) const {
    if (!get(from_) || !get(from_ + 1)) return std::nullopt;
    return monotone([&](size_t i) {
      // Beyond the two keys only the slope needs a value; it is flat there if none is known.
      const std::optional<double> there = get(i);
      return there ? *there : *get(i < from_ ? from_ : from_ + 1);
    });
  }

 private:
  double seconds(size_t key) const { return keys_[key].seconds; }

  // A second, at a key.
  template <class Of>
  double slope(const Of& of, size_t key, bool is_monotone) const {
    if (key == 0 || key + 1 == keys_.size()) return 0;  // at rest
    const double before = seconds(key - 1), after = seconds(key);
    const double to = (of(key) - of(key - 1)) / before, on = (of(key + 1) - of(key)) / after;
    // The mean of the two secants, each weighted by the other one's time: the slope of the parabola
    // through the three keys.
    const double mean = (to * after + on * before) / (before + after);
    if (!is_monotone) return mean;
    // Fritsch and Carlson (1980): a cubic is monotone if its slopes have the secants' sign and are
    // at most three times as steep.
    if (to * on <= 0) return 0;
    const double most = 3 * std::min(std::abs(to), std::abs(on));
    return std::clamp(mean, -most, most);
  }
  double hermite(double a, double b, double slope_a, double slope_b) const {
    const double t = share_, s = seconds(from_);
    const double t2 = t * t, t3 = t2 * t;
    return a * (2 * t3 - 3 * t2 + 1) + s * slope_a * (t3 - 2 * t2 + t) + b * (3 * t2 - 2 * t3) +
           s * slope_b * (t3 - t2);
  }

  const std::vector<ViewKey>& keys_;
  const size_t from_;
  const double share_;
};

double reachOf(const ViewOptions& view) {
  return length(vecOf(view.look_at->eye) - vecOf(view.look_at->target));
}

ViewOptions cameraBetween(const Between& at) {
  ViewOptions view = at.state(at.from()).view;
  if (!at.both([](const ViewState& s) { return s.view.look_at.has_value(); })) return view;
  const auto of = [&](auto get) {
    return [&at, get](size_t i) {
      const ViewOptions& there = at.state(i).view;
      // Keys that were never placed are none of a window's.
      return get(there.look_at ? there : at.state(at.from()).view);
    };
  };
  Vec3d target;
  for (int a = 0; a < 3; ++a)
    target[a] = at.smooth(
        of([a](const ViewOptions& v) { return v.look_at->target[static_cast<size_t>(a)]; }));
  // Each turning in the half of the sphere of the one before it: the short way round.
  std::vector<Quaternion> turnings;
  const size_t first = at.first();
  const auto turningAt = [&](size_t i) {
    while (first + turnings.size() <= i) {
      Quaternion q =
          of([](const ViewOptions& v) { return turningOf(axesOf(v)); })(first + turnings.size());
      double along = 0;
      if (!turnings.empty())
        for (size_t p = 0; p < 4; ++p) along += q[p] * turnings.back()[p];
      if (along < 0)
        for (double& part : q) part = -part;
      turnings.push_back(q);
    }
    return turnings[i - first];
  };
  Quaternion turning{};
  for (size_t p = 0; p < 4; ++p) turning[p] = at.smooth([&](size_t i) { return turningAt(i)[p]; });
  const auto [up, back] = upAndBack(turning);
  // Distances and zooms are mixed as logarithms, so that a camera approaches at an even pace.
  const double distance =
      std::exp(at.smooth(of([](const ViewOptions& v) { return std::log(reachOf(v)); })));
  view.look_at = ViewOptions::LookAt{arrayOf(target + back * distance), arrayOf(target)};
  view.up = arrayOf(up);
  view.zoom = std::exp(at.monotone(of([](const ViewOptions& v) { return std::log(v.zoom); })));
  view.field_of_view_deg =
      at.monotone(of([](const ViewOptions& v) { return v.field_of_view_deg; }));
  return view;
}

// The numbers of an option in a key's state; none if it has no value that stands for being unset.
OptionNumbers numbersOf(const OptionEntry& entry, const ViewState& state) {
  std::optional<OptionValue> value = entry.get(state);
  if (!value) value = entry.unset;
  return value ? optionNumbers(entry.kind, *value) : OptionNumbers();
}

// Sets the numbers of an option between those of the two keys, if both keys have it in one form.
void setBetween(const Between& at, const OptionEntry& entry, ViewState& state) {
  std::optional<OptionValue> value = entry.get(state);
  // An option that neither key sets stays unset.
  if (!value && entry.get(at.state(at.from() + 1))) value = entry.unset;
  if (!value) return;
  // Options without numbers, such as maps, keep the value of the earlier key.
  const OptionNumbers here = optionNumbers(entry.kind, *value);
  if (here.numbers.empty()) return;
  std::vector<OptionNumbers> around;  // of the keys from at.first() on, as far as slopes look
  for (size_t i = at.first(); i <= at.last(); ++i) around.push_back(numbersOf(entry, at.state(i)));
  std::vector<std::optional<double>> numbers;
  for (size_t n = 0; n < here.numbers.size(); ++n)
    numbers.push_back(at.number([&](size_t i) {
      const OptionNumbers& there = around[i - at.first()];
      return there.hasFormOf(here) ? there.numbers[n] : std::nullopt;
    }));
  const OptionValue made = withNumbers(entry.kind, *value, numbers);
  if (made != *value) entry.set(state, made);
}

ViewState keyFrameAt(const ViewPath& path, const ViewState& now, double second) {
  size_t from = 0;
  double share = 0;
  // The last frame may lie behind the last key by a rounding error, so that the loop stays before
  // it.
  while (from + 1 < path.keys.size()) {
    const double seconds = path.keys[from].seconds;
    share = std::min(second / seconds, 1.0);
    if (second < seconds || from + 2 == path.keys.size()) break;
    second -= seconds;
    ++from;
  }
  // A frame at a key is that key's state itself, without rounding.
  const bool is_key = path.keys.size() == 1 || share <= 0 || share >= 1;
  ViewState state = path.keys[is_key && share >= 1 ? from + 1 : from].state;
  if (!is_key) {
    const Between at(path.keys, from, share);
    state.view = cameraBetween(at);
    for (const OptionEntry& entry : optionTable())
      if (entry.part != OptionPart::kCamera) setBetween(at, entry, state);
  }
  // The cross hair and the slices are the window's, whatever the film shows.
  state.cross = now.cross;
  state.shows_slices = now.shows_slices;
  return state;
}

}  // namespace

double secondsOf(const ViewPath& path) {
  if (path.kind == ViewPath::Kind::kTurn)
    return static_cast<double>(path.turn_frames) / path.frames_per_second;
  double seconds = 0;
  for (size_t i = 0; i + 1 < path.keys.size(); ++i) seconds += path.keys[i].seconds;
  return seconds;
}

int64_t frameCount(const ViewPath& path) {
  if (path.kind == ViewPath::Kind::kTurn)
    return std::clamp<int64_t>(path.turn_frames, 1, ViewPath::kMostFrames);
  if (path.keys.empty()) return 0;
  // A frame's length that rounding took off is still one.
  const double frames = std::floor(secondsOf(path) * path.frames_per_second + 1e-6) + 1;
  return static_cast<int64_t>(std::min(frames, static_cast<double>(ViewPath::kMostFrames)));
}

ViewState stateAt(const ViewPath& path, const ViewState& now, int64_t frame) {
  SLUICE_CHECK_LT(frame, frameCount(path));
  if (path.kind == ViewPath::Kind::kKeys)
    return keyFrameAt(path, now, static_cast<double>(frame) / path.frames_per_second);
  ViewState state = now;
  state.view =
      turn(now.view, 360 * static_cast<double>(frame) / static_cast<double>(frameCount(path)));
  return state;
}

std::optional<std::string> jumpsAlong(const ViewPath& path) {
  if (path.kind == ViewPath::Kind::kTurn) return std::nullopt;
  std::vector<std::string> places;
  for (const OptionEntry& entry : optionTable()) {
    if (entry.part == OptionPart::kCamera || entry.option.empty()) continue;
    const auto numbersAt = [&](size_t key) { return numbersOf(entry, path.keys[key].state); };
    for (size_t i = 0; i + 1 < path.keys.size(); ++i)
      if (!numbersAt(i).hasFormOf(numbersAt(i + 1))) {
        places.push_back(placeOf(entry.option));
        break;
      }
  }
  if (places.empty()) return std::nullopt;
  return fmt::format(
      "{}: set in some key frames only, or in different forms, so that the film jumps there",
      fmt::join(places, ", "));
}

std::string pathFileFor(const std::string& frames) {
  const std::filesystem::path path(frames);
  std::string stem = path.stem().string();
  stem.resize(std::min(stem.find_first_of("%#"), stem.size()));
  while (!stem.empty() && (stem.back() == '_' || stem.back() == '-' || stem.back() == '.'))
    stem.pop_back();
  return (path.parent_path() / ((stem.empty() ? "path" : stem) + ".json")).string();
}

}  // namespace sluice

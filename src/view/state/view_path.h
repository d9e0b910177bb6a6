// ViewPath: views one after the other, the frames of a film: once around, or along key frames.
// Plain data and pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/options/view_state.h"

namespace sluice {

// A view that the film comes through.
struct ViewKey {
  ViewState state;     // placed
  double seconds = 2;  // to the next one, above 0; unused for the last one
  friend bool operator==(const ViewKey&, const ViewKey&) = default;
};

struct ViewPath {
  enum class Kind { kTurn, kKeys };
  Kind kind = Kind::kTurn;
  int64_t turn_frames = 90;  // frames of a turn about the vertical of the view, at least 1
  std::vector<ViewKey> keys;
  double frames_per_second = 25;  // above 0
  friend bool operator==(const ViewPath&, const ViewPath&) = default;

  static constexpr int64_t kMostFrames = 100'000;
};

// 0: there are no key frames. The first and the last key frame are frames, and a turn ends a frame
// before it would begin again. At most kMostFrames.
int64_t frameCount(const ViewPath& path);
double secondsOf(const ViewPath& path);

// The state that frame number `frame` shows. `now` gives the view that a turn starts from and, for
// key frames, everything that is no part of a film (such as the slices shown).
//
// Cameras and the numbers of all options come through the key frames smoothly, at rest at both
// ends: target, distance and zoom as logarithms, and rotation as quaternions, by cubic Hermite
// splines; numbers of options, which may not overshoot (thresholds, light, steps, crop boxes), by
// monotone splines (Fritsch and Carlson, Monotone piecewise cubic interpolation, 1980). What is a
// number follows from the table of options (option_numbers.h), and so does the number of a key that
// does not set one (OptionEntry::unset). If two keys do not both have an
// option in the same form (a threshold in one and points in the other, maps, modes), the earlier
// key's holds until the later is reached. Requires: 0 <= frame < frameCount().
ViewState stateAt(const ViewPath& path, const ViewState& now, int64_t frame);

// A line about the numbers that jump at a key frame, because it and the one before do not both have
// them in the same form; nullopt: none does. A step that is not set, for example, follows from
// the view, so that there is no number to start from. Names them by their places in a saved view.
std::optional<std::string> jumpsAlong(const ViewPath& path);

// "turn.json" next to "turn_%04d.png": the view and its path, from which `sluice render` makes the
// same frames.
std::string pathFileFor(const std::string& frames);

}  // namespace sluice

// Options that were given for nothing: another option, or the volume, leaves them without any
// effect on the picture. A table has a rule for each reason; whoever draws the picture prints a
// line for each option. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace sluice {

// The facts of a picture that decide. Whoever does not know one leaves it as it is: nothing is idle
// then.
struct PictureFacts {
  bool is_attenuated = true;  // by the mode
  bool has_colors = true;     // ModeTraits
  bool hides = true;          // ModeTraits
  bool is_perspective = true;
  bool step_counts = true;     // stepCounts()
  bool asks_to_blend = false;  // --combine blend
  bool merges = true;          // --algorithm merged
  bool is_random = true;       // --policy random
  bool is_cut = true;          // drawn from levels of resolution, if the volume has them
  bool is_culled = true;       // blocks that others hide are left out
  bool is_drawn = true;        // not only planned
  bool is_film = true;
  bool is_lit = true;
  bool asks_to_integrate = false;
  bool integrates = true;       // Scene::integrates()
  bool has_long_steps = false;  // too long to integrate
  bool has_surfaces = false;
  bool shows_labels = false;
  bool has_label_colors = false;  // a table, or looks of all labels, give the colours
  // Looks of the channels that are shown leave none of these of the picture's own.
  bool map_is_replaced = false, range_is_replaced = false, opacity_is_replaced = false;
  bool opacities_are_replaced = false;  // a threshold, points, or a file
  size_t layers = 2;                    // channels, and the volume of --over
  bool is_blended = false;
  int64_t time_steps = 2;
  size_t levels = 2;  // of resolution, that pictures are drawn from
};

// "--fov changes nothing with an orthographic camera; ...", a line for each idle option of those
// that were given ("--fov").
std::vector<std::string> idleOptions(const std::set<std::string>& given, const PictureFacts& facts);

}  // namespace sluice

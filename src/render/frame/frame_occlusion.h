// FrameOcclusion: the parts of a frame's boxes that are hidden by boxes drawn before them (Li 2003,
// section 4). It tells when the opacity map is to be updated and which part of a box may still
// show.
//
// Used for one frame, whose boxes come front to back. It needs no device: the caller passes in the
// map's values. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "src/base/values/vec.h"
#include "src/device/frame_values.h"
#include "src/texture/texture_plan.h"
#include "src/visibility/occlusion/box_occlusion.h"
#include "src/visibility/occlusion/map_updates.h"
#include "src/visibility/occlusion/opacity_map.h"

namespace sluice {

// The paper's ESS, ESS+M (maps are made and asked, nothing is left out), ESS+C and ESS+CC.
enum class Occlusion { kOff, kMap, kCull, kClip };
inline constexpr std::array kOcclusions = {Occlusion::kOff, Occlusion::kMap, Occlusion::kCull,
                                           Occlusion::kClip};
constexpr std::string_view name(Occlusion occlusion) {
  constexpr std::array<std::string_view, kOcclusions.size()> kNames = {"off", "map", "cull",
                                                                       "clip"};
  return kNames[static_cast<size_t>(occlusion)];
}

struct OcclusionReport {
  int updates_wanted = 0, updates = 0;  // updates of the map: k and k' (section 4.4)
  // Cells of all boxes that a frame without occlusion draws, of the boxes that were left out, and
  // cells cut off boxes that were drawn.
  int64_t cells = 0, cells_culled = 0, cells_clipped = 0;
  int64_t chunks_hidden = 0;  // chunks that only hold culled boxes
  double seconds = 0;         // updating the map; part of the time for drawing

  double skippedShare() const {
    return cells == 0
               ? 0
               : static_cast<double>(cells_culled + cells_clipped) / static_cast<double>(cells);
  }
};

class FrameOcclusion {
 public:
  struct Work {
    Box3 hull;          // hull of the cells that may be drawn
    int64_t cells = 0;  // in the boxes that are to come
    int updates = 0;    // wanted
    double opaque = 1;  // opacity from which on boxes behind are hidden
  };
  // Requires: how != kOff, work.hull not empty.
  FrameOcclusion(Occlusion how, const FrameSetup& setup, const EyePosition& eye, const Work& work);

  // Whether none of these cells can show.
  bool hides(const Box3& cells) const;
  // The part of a box to draw: nullopt if it is culled. Counts it.
  std::optional<Box3> visible(const Box3& cells);
  // Counts cells that were left out without a look at their boxes. Requires: hides() them.
  void leaveOut(int64_t cells);

  // To be called after the last box from visible() was drawn; true if the map is to be updated now.
  bool isUpdateDue() { return schedule_.isDueAfter(std::exchange(last_drawn_, 0)); }
  // The cells of the map, for the device to fill.
  MapGrid grid() const;
  // Requires: least.size() == side * side of the grid.
  void update(std::span<const float> least) { map_.update(least); }

  const OpacityMap& map() const { return map_; }
  OcclusionReport report() const;
  // The share of the cells that are hidden, whether they are drawn or not.
  double hiddenShare() const {
    return report_.cells == 0
               ? 0
               : static_cast<double>(hidden_cells_) / static_cast<double>(report_.cells);
  }

 private:
  Box3 shownPart(const Box3& cells) const;
  RealBox asReal(const Box3& cells) const { return {toDouble(cells.lo), toDouble(cells.hi)}; }

  const Occlusion how_;
  const float threshold_;
  const std::array<std::array<double, 4>, 3> clip_from_index_;
  const MapProjection projection_;
  OpacityMap map_;
  UpdateSchedule schedule_;
  int64_t last_drawn_ = 0;
  int64_t hidden_cells_ = 0;
  OcclusionReport report_;
};

}  // namespace sluice

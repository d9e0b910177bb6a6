// A frame of a scene with several levels as pictures that get better until it is the best or the
// time is over (src/render/frame/refinement.h). Each is whole; the last one is the frame. All
// layers of the scene get better together.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "src/library/drawing/scene/scene.h"
#include "src/render/frame/refinement.h"

namespace sluice {

// A picture, with the options that it was drawn with and the seconds from the begin of its row.
struct BetterPicture {
  const Frame& frame;
  const FrameOptions& options;
  int number = 0;  // in the row, from 0
  double seconds = 0;
};

// The record of one picture of a row.
struct RefinedPicture {
  double seconds = 0, step_vox = 0;
  std::optional<CutSummary> cut;
};

struct RefinedFrame {
  SceneFrame frame;      // the last picture, whole
  FrameOptions options;  // its own
  std::vector<RefinedPicture> pictures;
};

// The last picture of a row: that of the cut of its options; or the one that is drawn if nobody
// asks for a cut, from the finest level if coarser ones show something else. A row with a time
// limit ends with the cut, whatever is asked for: a cut can be refined in part when the time ends,
// the finest level cannot.
enum class RowEnd { kCut, kUnasked };
// The options of such a picture. FrameOptions::time_limit_s is the row's limit.
FrameOptions lastOptions(const Scene& scene, FrameOptions options, RowEnd end);

// Whether frames of the scene with these options can be such a row: a layer has several levels to
// draw from.
bool canRefine(const Scene& scene, const FrameOptions& options);

// Draws the row. Each picture is passed to `take` as soon as it is there. `began`: where seconds
// are counted from. `has_step`: the distance between slices is that of the options in all pictures;
// otherwise it follows from what each shows. `until`: the row's limit. Throws Error, Interrupted.
// Requires: canRefine().
RefinedFrame drawRefined(Scene& scene, const FrameOptions& options, bool has_step, RowEnd end,
                         Deadline::TimePoint began, std::optional<Deadline::TimePoint> until,
                         const std::function<void(const BetterPicture&)>& take);

}  // namespace sluice

// A frame of a volume with several levels as pictures that get better until it is the best or the
// time is over (src/render/frame/refinement.h). Each is whole; the last one is the frame.
#pragma once

#include <nlohmann/json.hpp>

#include <functional>
#include <optional>

#include "src/render/frame/refinement.h"
#include "tools/scene/scene.h"
#include "tools/scene/strip_drawing.h"

namespace sluice {

// A picture, with the options that it was drawn with and the seconds from the begin of its row.
struct BetterPicture {
  const Frame& frame;
  const FrameOptions& options;
  int number = 0;  // in the row, from 0
  double seconds = 0;
};

struct RefinedFrame {
  WrittenFrame frame;                                 // the last picture, not yet written
  FrameOptions options;                               // its own
  nlohmann::json pictures = nlohmann::json::array();  // `cut`, `seconds` and `step` of each
};

// Draws the row. Each picture is passed to `take` as soon as it is there. `began`: where seconds
// are counted from. Throws Error, Interrupted.
RefinedFrame drawRefined(Scene& scene, const FrameOptions& options,
                         const Refinement::StepOf& step_of, Deadline::TimePoint began,
                         std::optional<Deadline::TimePoint> until,
                         const std::function<void(const BetterPicture&)>& take);

// "level 2", "levels 1, 2", and whether the picture will improve, for people.
std::string refinedLine(const CutSummary& cut);

}  // namespace sluice

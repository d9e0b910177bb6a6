#include "tools/scene/refined_drawing.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "src/base/error.h"
#include "src/library/drawing/empty_picture.h"
#include "tools/outputs/report.h"

namespace sluice {

RefinedFrame drawRefined(Scene& scene, const FrameOptions& options,
                         const Refinement::StepOf& step_of, Deadline::TimePoint began,
                         std::optional<Deadline::TimePoint> until,
                         const std::function<void(const BetterPicture&)>& take) {
  Refinement row(*scene.session, {scene.volume.step(), scene.transfer, scene.pool}, options,
                 step_of, until);
  RefinedFrame refined;
  std::optional<Frame> last;
  for (int number = 0; std::optional<Frame> frame = row.next(); ++number) {
    if (last) scene.device->reuse(std::move(last->picture));
    last = std::move(frame);
    scene.noteMemory();
    // A sample shows a part of the voxels, whatever the pixel error.
    if (scene.volume.sample && last->report.cut && last->report.cut->coarse_share > 0)
      last->report.cut->is_final = false;
    refined.options = row.shown();
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - began;
    nlohmann::json picture{{"seconds", since.count()}, {"step", refined.options.step_vox}};
    if (last->report.cut) picture["cut"] = cutJson(*last->report.cut);
    refined.pictures.push_back(std::move(picture));
    take({*last, refined.options, number, since.count()});
  }
  SLUICE_CHECK(last.has_value());
  refined.frame.report = last->report;
  refined.frame.blocks = last->blocks;
  refined.frame.shows_something = !showsNothing(last->picture);
  refined.frame.whole = std::move(last);
  return refined;
}

std::string refinedLine(const CutSummary& cut) {
  std::string levels;
  for (const CutSummary::Level& level : cut.levels)
    levels += fmt::format("{}{}", levels.empty() ? "" : ", ", level.level);
  return fmt::format("level{} {}, {}", cut.levels.size() == 1 ? "" : "s", levels,
                     cut.is_final ? "final" : "will improve");
}

}  // namespace sluice

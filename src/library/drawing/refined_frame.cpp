#include "src/library/drawing/refined_frame.h"

#include <chrono>
#include <utility>

#include "src/base/error.h"
#include "src/library/drawing/empty_picture.h"

namespace sluice {

RefinedFrame drawRefined(Scene& scene, const FrameOptions& options, bool has_step,
                         Deadline::TimePoint began, std::optional<Deadline::TimePoint> until,
                         const std::function<void(const BetterPicture&)>& take) {
  const TimeStep step = scene.volume.step();
  const auto step_of = [&](const CutOptions& cut) {
    if (has_step) return options.step_vox;
    FrameOptions of_cut = options;
    of_cut.cut = cut;
    of_cut.time_limit_s.reset();  // the last picture is the one without a limit
    return scene.chosenStep(step, of_cut);
  };
  Refinement row(*scene.session, {step, scene.look.transfer, scene.pool}, options, step_of, until);
  RefinedFrame refined;
  std::optional<Frame> last;
  for (int number = 0;; ++number) {
    std::optional<Frame> frame = row.next();
    if (!frame) break;
    if (last) scene.device->reuse(std::move(last->picture));
    last = std::move(frame);
    scene.noteMemory();
    // A sample shows a part of the voxels, whatever the pixel error.
    if (scene.volume.sample && last->report.cut && last->report.cut->coarse_share > 0)
      last->report.cut->is_final = false;
    refined.options = row.shown();
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - began;
    refined.pictures.push_back({since.count(), refined.options.step_vox, last->report.cut});
    take({*last, refined.options, number, since.count()});
  }
  SLUICE_CHECK(last.has_value());
  refined.frame.report = last->report;
  refined.frame.blocks = last->blocks;
  refined.frame.shows_something = !showsNothing(last->picture);
  refined.frame.whole = std::move(last);
  return refined;
}

}  // namespace sluice

// The parts of a frame that shows several sessions as one medium, see Session::parts().
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "src/render/session/session.h"
#include "src/render/session/union_plan.h"

namespace sluice {
Session::Parts Session::parts(std::span<Session* const> sessions) {
  Stopwatch watch;
  Parts result;
  std::vector<std::optional<ReadLimit>> limits(sessions.size());
  std::vector<Planner*> planners;
  std::vector<BlockQuestion> questions;
  for (size_t i = 0; i < sessions.size(); ++i) {
    Session& session = *sessions[i];
    SLUICE_CHECK(session.transfer_ != nullptr);
    session.takeLearntRanges();
    FrameOptions options = session.options_;
    options.integrates = false;
    const TimeStep& step = session.step_;
    const LookPtr look = session.planner_.look(step, session.transfer_, options.mode);
    limits[i] = session.readLimit(look);
    if (limits[i]) options.time_limit_s.reset();  // all blocks of the cut come in time
    const View view = resolve(options, step.source->layout());
    planners.push_back(&session.planner_);
    questions.push_back(
        Planner::question(step, look, view, options, limits[i] ? &*limits[i] : nullptr));
    SLUICE_CHECK_EQ(questions[i].cut.has_value(), questions.front().cut.has_value());
    result.of_sessions.push_back({&session, step, look, nullptr, nullptr, options,
                                  session.opened_with_.lit && options.shades,
                                  session.lessons_.draw_s, session.trace_, session.frame_number_});
  }
  const std::vector<VisibleBlocksPtr> visible = Planner::visibleTogether(planners, questions);
  // All channels are sampled at the same depths, so that the finest step of any applies to all.
  double step_vox = INFINITY;
  for (size_t i = 0; i < sessions.size(); ++i) {
    Part& part = result.of_sessions[i];
    part.visible = visible[i];
    sessions[i]->visible_ = visible[i];
    step_vox = std::min(step_vox, sessions[i]->stepForCut(*visible[i], part.options));
  }
  for (Part& part : result.of_sessions) {
    part.options.step_vox = step_vox;
    part.options.algorithm = blendedAlgorithm(part.options.algorithm, visible);
  }
  result.classify_s = watch.lap();

  const Part& first = result.of_sessions.front();
  const Box3 crop = cropCells(first.options, first.step.ranges->layout.dims);
  UnionKey key{{}, first.options.algorithm, first.options.merge_order, first.step.time, crop};
  std::vector<ChannelBlocks> blocks;
  // The union is kept as long as all channels show the same blocks.
  for (const Part& part : result.of_sessions) {
    key.visible.emplace_back(part.visible);
    blocks.push_back({part.step.layout(), part.visible, part.session->page()});
  }
  result.all = first.session->union_.of(std::move(key), [&] {
    return unionPlan(blocks,
                     {first.options.algorithm, first.options.merge_order, first.step.time, crop});
  });
  for (Part& part : result.of_sessions) {
    Session& session = *part.session;
    part.plan = session.planner_.plan(part.step, part.visible, part.options, result.all);
    // Reading begun for a frame of one session alone would take the room of this frame.
    session.lessons_.unfinished.reset();
    session.read_afterwards_.reset();
    session.afterwards_.reset();
    session.residency_.forgetUnused(*part.plan);
  }
  result.plan_s = watch.lap();
  return result;
}

void Session::noteDrawn(const Part& part, double draw_s, double reading_s, uint64_t read_bytes,
                        FrameReport& report) {
  lessons_.draw_s = draw_s;
  noteDrawn(part.visible, reading_s, read_bytes, report);
}

}  // namespace sluice

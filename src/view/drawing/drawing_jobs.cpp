// The jobs that draw and answer questions. Opening is in drawing_opening.cpp, writing in
// drawing_saves.cpp.
#include "src/view/drawing/drawing_jobs.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "src/base/field_names.h"
#include "src/base/threads/clock.h"
#include "src/options/option_rules.h"

namespace sluice {
namespace {

// How long the whole picture waits for data on disk before it is shown without the missing parts.
constexpr double kRefine_s = 0.4;
// With levels of resolution there is a whole picture already, and another costs its drawing.
constexpr double kRefineLevels_s = 0.8;
// If less than this share arrived in that time, it is quicker to wait for all of it.
constexpr double kWorthShowing = 0.01;
constexpr std::array<float, 3> kPaneColor{0.09F, 0.09F, 0.1F};

std::vector<uint8_t> greys(const SliceValues& slice, std::array<double, 2> range) {
  std::vector<uint8_t> rgba(slice.values.size() * 4, 255);
  const auto lo = static_cast<float>(range[0]);
  const auto factor = static_cast<float>(255 / (range[1] - range[0]));
  for (size_t i = 0; i < slice.values.size(); ++i) {
    const float at = (slice.values[i] - lo) * factor;
    // NaN is black, too: a comparison with it is false.
    const auto grey = static_cast<uint8_t>(at > 0 ? std::min(at, 255.0F) : 0);
    rgba[4 * i] = rgba[4 * i + 1] = rgba[4 * i + 2] = grey;
  }
  return rgba;
}

// The window's names of the options that its check boxes stand for.
constexpr std::array kBoxes = std::to_array<std::pair<std::string_view, std::string_view>>(
    {{"--modulate", "\"by gradient\""},
     {"--shadows", "\"shadows\""},
     {"--occlusion-light", "\"occlusion\""}});

// A line in the words of the window; options without a check box keep their names.
std::string lineInWindow(std::string line) {
  const auto isNamed = [&](const auto& box) { return line.find(box.first) != std::string::npos; };
  if (std::ranges::none_of(kBoxes, isNamed)) return line;
  return renamed(line, [](std::string_view option) {
    const auto* box =
        std::ranges::find(kBoxes, option, [](const auto& each) { return each.first; });
    return std::string(box == kBoxes.end() ? option : box->second);
  });
}

// Finds an answer and tells it, also if it cannot be found: the window waits for it.
template <class Find, class Tell>
void tellAnswer(const Find& find, const Tell& tell) {
  try {
    find();
  } catch (const Cancelled&) {
    throw;  // the question stays, unless there is a newer one
  } catch (const std::exception&) {
    tell();
    throw;
  }
  tell();
}

}  // namespace

void DrawingJobs::run(const Job& job) {
  try {
    std::visit([&](const auto& task) { run(task, job); }, job.task);
  } catch (const Cancelled&) {
    queue_.noteCancelled(job);
  } catch (const std::exception& error) {
    tellFailure(lineInWindow(lineInOptions(error)));
    queue_.noteFailed(job);
  }
}

void DrawingJobs::tellFailure(const std::string& line) {
  news_.add([&](News& news) { news.failures.push_back(line); });
}

ProgressFunction DrawingJobs::progress() const {
  return [this](const Progress& progress) {
    // The library calls this from its own threads, too; the queue takes any.
    queue_.noteProgress(progress.share(), progress.stage != Progress::Stage::kDrawing);
  };
}

void DrawingJobs::useLook(const ViewState& state, bool is_shown) {
  // Making a look reads files and may take a histogram, so that a look that is the same is not set
  // again.
  const LookOptions look = lookOf(state);
  // There is none if opening another volume failed after the last one was let go (openVolume()).
  if (opened_.renderer == nullptr) {
    opened_.renderer = makeRenderer(*opened_.volume, look);
    opened_.look = look;
  } else if (look != opened_.look) {
    opened_.renderer->setLook(look);
    opened_.look = look;
  } else if (look == opened_.shown_look) {
    return;
  }
  // Frames of a film have looks of their own, which the panels must not show.
  if (!is_shown) return;
  opened_.shown_look = look;
  auto shown = std::make_unique<ShownLook>(opened_.renderer->shownLook());
  // The swap leaves the look that nobody took to this thread, which destroys it outside of the
  // lock.
  news_.add([&](News& news) { news.look.swap(shown); });
}

ViewOptions DrawingJobs::placed(const ViewState& state, int width, int height, const Job& job) {
  useLook(state, false);  // what is shown has the newest wish's
  return opened_.renderer->placed(pictureOf(state, width, height), progress(), job.stop);
}

ShownPicture DrawingJobs::draw(const Job& job, const PictureOptions& picture) {
  Renderer& renderer = *opened_.renderer;
  const auto background = job.wish->wish.state.background.value_or(kPaneColor);
  ShownPicture shown;
  double convert_s = 0;
  // The picture stays on the graphics card if it can. nullopt says that this look or device needs
  // pixels.
  shown.screen = renderer.drawOnScreen(picture, background, progress(), job.stop);
  if (shown.screen) {
    shown.width = shown.screen->width;
    shown.height = shown.screen->height;
    shown.missing_share = shown.screen->missing_share;
  } else {
    const Image image = renderer.draw(picture, progress(), job.stop);
    shown.width = image.width;
    shown.height = image.height;
    shown.missing_share = image.missing_share;
    const Stopwatch watch;
    shown.rgba = image.toRgba8(background);
    convert_s = watch.seconds();
  }
  RenderReport report = renderer.report();
  shown.why_empty = std::move(report.why_empty);
  shown.why_added = lineInWindow(std::move(report.why_added));
  shown.levels = std::move(report.levels);
  shown.will_improve = report.will_improve;
  shown.is_refined = report.is_refined;
  // Reading and planning, apart from drawing: only drawing scales with pixels and steps.
  double other_s = std::max(0.0, report.seconds - report.draw_seconds);
  // A picture of levels reads as much as its time allows: this says nothing of the next one.
  if (!shown.levels.empty() && report.pages_loaded > 0)
    other_s = std::min(other_s, opened_.pace.fixed_s);
  // A picture with missing parts was drawn faster than a whole one.
  if (report.missing_share == 0)
    opened_.pace =
        learned(opened_.pace, {static_cast<double>(picture.width) * picture.height, report.step_vox,
                               report.draw_seconds, convert_s, other_s});
  return shown;
}

void DrawingJobs::run(const PreviewJob&, const Job& job) {
  const Wish& wish = job.wish->wish;
  const Stopwatch watch;
  useLook(wish.state);
  PictureOptions picture = pictureOf(wish.state, wish.width, wish.height);
  const double budget_s = drawingBudget(options_.budget_s, wish.showing_s);
  // The quality is chosen to meet the budget. The limit is looser, so that a picture which takes a
  // little longer than expected is still whole.
  picture.time_limit_s = 1.25 * budget_s;
  // The question comes before the size is changed: the steps of the whole picture are those to be
  // stretched.
  const auto [step, from_levels] = opened_.renderer->sampling(picture, progress(), job.stop);
  const Quality quality =
      qualityWithin(opened_.pace, static_cast<double>(wish.width) * wish.height, step, budget_s,
                    from_levels ? PreviewSteps::kFollowPixels : PreviewSteps::kFixed);
  if (!quality.isFull()) {
    picture.width = std::max(1, static_cast<int>(std::lround(wish.width * quality.scale)));
    picture.height = std::max(1, static_cast<int>(std::lround(wish.height * quality.scale)));
    // The library chooses coarser levels for a smaller picture, and the steps that suit them.
    if (!from_levels || wish.state.step_vox) picture.step_vox = step * quality.step_factor;
  }
  ShownPicture shown = draw(job, picture);
  // A preview may show levels that the whole picture does not (PictureOptions::time_limit_s).
  const bool is_complete = quality.isFull() && shown.missing_share == 0 && shown.levels.empty();
  deliver(*job.wish, std::move(shown), is_complete, watch.seconds());
}

void DrawingJobs::run(const PictureJob&, const Job& job) {
  const Wish& wish = job.wish->wish;
  const Stopwatch watch;
  useLook(wish.state);
  PictureOptions picture = pictureOf(wish.state, wish.width, wish.height);
  // The blocks of the next step are read while this one is drawn; previews have no time for it.
  picture.next_time = wish.next_time;
  const bool from_levels = opened_.renderer->sampling(picture, progress(), job.stop).from_levels;
  double missing = 1, limit_s = from_levels ? kRefineLevels_s : kRefine_s;
  // Shows the parts that are there as they come, as long as each adds enough to be worth a picture;
  // with levels of resolution whole pictures, each finer than the one before. Such a picture may
  // copy what the one before had in other chunks, so that each gets more time than the last took.
  while (true) {
    picture.time_limit_s = limit_s;
    const Stopwatch since_last;
    ShownPicture shown = draw(job, picture);
    if (shown.will_improve) limit_s = 2 * std::max(limit_s, since_last.seconds());
    const double came = missing - shown.missing_share;
    missing = shown.missing_share;
    const bool is_complete = missing == 0 && !shown.will_improve;
    const bool goes_on = shown.will_improve || came >= kWorthShowing;
    deliver(*job.wish, std::move(shown), is_complete, watch.seconds());
    if (is_complete) return;
    // Too little came in this time. The picture below waits for all of it.
    if (!goes_on) break;
  }
  picture.time_limit_s.reset();
  deliver(*job.wish, draw(job, picture), true, watch.seconds());
}

void DrawingJobs::deliver(const NumberedWish& wish, ShownPicture picture, bool is_complete,
                          double seconds) {
  auto shown = std::make_unique<ShownPicture>(std::move(picture));
  shown->wish = wish.number;
  shown->is_complete = is_complete;
  shown->state = wish.wish.state;
  shown->seconds = seconds;
  // The one before, if nobody took it, goes when nobody waits for the lock.
  news_.add([&](News& news) { news.picture.swap(shown); });
  queue_.notePicture(wish, is_complete);
}

void DrawingJobs::run(const SlicesJob&, const Job& job) {
  const ViewState& state = job.wish->wish.state;
  useLook(state);
  // Slices are kept by place and step, since a new range recolours them without reading.
  const VolumeInfo& info = opened_.volume->info();
  std::array<double, 2> range = state.look.range.value_or(info.value_range);
  // A volume of one value has no range to spread over the greys.
  if (range[0] == range[1]) range[1] = range[0] + 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    Opened::Slice& kept = opened_.slices[a];
    const int64_t at = std::clamp<int64_t>(state.cross[a], 0, info.dims[a] - 1);
    const bool is_same = kept.at == at && kept.time == state.time;
    if (is_same && kept.range == range) continue;
    if (!is_same) {
      // Invalid until the read succeeds, which may be cancelled.
      kept.at = -1;
      kept.values = opened_.renderer->slice(
          {.axis = axis, .at = at, .time = state.time, .most = 512}, job.stop);
      kept.at = at;
      kept.time = state.time;
    }
    kept.range = range;
    ShownSlice shown{.axis = axis,
                     .at = at,
                     .time = state.time,
                     .width = kept.values.width,
                     .height = kept.values.height,
                     .rgba = greys(kept.values, range),
                     .values = kept.values};
    news_.add([&](News& news) {
      // A slice that nobody has taken yet is replaced.
      std::erase_if(news.slices, [axis](const ShownSlice& other) { return other.axis == axis; });
      news.slices.push_back(std::move(shown));
    });
  }
  queue_.noteSlices(job.wish->number);
}

void DrawingJobs::run(const PlaceJob& task, const Job& job) {
  PlacedNews answer{.number = task.number, .view = {}};
  tellAnswer([&] { answer.view = placed(task.wish.state, task.wish.width, task.wish.height, job); },
             [&] {
               news_.add([&](News& news) { news.placed = answer; });
               queue_.notePlaced(task);
             });
}

void DrawingJobs::run(const ProbeJob& task, const Job& job) {
  const Wish& wish = job.wish->wish;
  ProbeNews answer{.number = task.number, .found = {}};
  tellAnswer(
      [&] {
        useLook(wish.state);
        answer.found = opened_.renderer->probe(pictureOf(wish.state, wish.width, wish.height),
                                               task.right, task.down, job.stop);
      },
      [&] {
        news_.add([&](News& news) { news.probe = answer; });
        queue_.noteProbed(task);
      });
}

void DrawingJobs::run(const ReportJob& task, const Job&) {
  if (opened_.renderer == nullptr) return;  // see useLook()
  auto report = std::make_unique<RenderReport>(opened_.renderer->report(task.maps));
  news_.add([&](News& news) { news.report = std::move(report); });
}

}  // namespace sluice

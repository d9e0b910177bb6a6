// sluice bench view: how soon a window would have a picture after a movement of the hand, and
// whether its loop ever waits.
#include <fmt/format.h>
#include <sluice/renderer.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/options/option_rules.h"
#include "src/options/option_table.h"
#include "src/view/drawing/drawing_thread.h"
#include "src/view/state/editing/camera_gestures.h"
#include "src/view/state/editing/transfer_edit.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/option_group.h"
#include "tools/command_line/progress_line.h"
#include "tools/options/view_arguments.h"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;

// The thing that the hand moves.
enum class DragKind { kThreshold, kView };

struct ViewBench {
  ViewedVolume volume;
  DrawingOptions drawing;
  int width = 800, height = 600;
  DragKind drag = DragKind::kThreshold;
  double threshold = 0;  // start of a drag of the threshold
  int events = 120;      // events of a drag
  double events_per_second = 60;
  int drags = 3;
};

nlohmann::json spread(std::vector<double> times) {
  if (times.empty()) return {{"p50", 0}, {"p95", 0}, {"max", 0}};
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[std::min(times.size() - 1,
                          static_cast<size_t>(share * static_cast<double>(times.size())))];
  };
  return {{"p50", at(0.5)}, {"p95", at(0.95)}, {"max", times.back()}};
}

// What a window does in a turn of its loop, but for drawing itself.
class Loop {
 public:
  explicit Loop(DrawingThread& desk) : desk_(desk) {}

  void turn() {
    interruption().throwIfStopped();
    const Stopwatch watch;
    News news = desk_.take();
    const DeskStatus status = desk_.status();
    if (news.opened) opened = std::move(news.opened);
    if (news.picture) picture = std::move(news.picture);
    completed = status.completed;
    turn_s.push_back(watch.seconds());
    if (!news.failures.empty()) fail("{}", news.failures.front());
  }
  uint64_t wish(const Wish& wish) {
    const Stopwatch watch;
    const uint64_t number = desk_.wish(wish);
    turn_s.push_back(watch.seconds());
    return number;
  }
  template <class Until>
  void turnUntil(const Until& until) {
    while (!until()) {
      turn();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  void turnUntil(Clock::time_point then) {
    turnUntil([then] { return Clock::now() >= then; });
  }

  std::unique_ptr<OpenedVolumeNews> opened;
  std::unique_ptr<ShownPicture> picture;
  uint64_t completed = 0;
  std::vector<double> turn_s;

 private:
  DrawingThread& desk_;
};

// Event i of a drag, from 1: a quarter of the range up and back to the start, or the same way round
// the volume. There is no event 0, which would move nothing: no window sends such a wish, and its
// answer, for which nothing new is loaded, would be the best of a drag.
void move(ViewState& state, const ViewBench& bench, std::array<double, 2> range, int i) {
  const double part = static_cast<double>(i) / bench.events;
  const double up = part < 0.5 ? 2 * part : 2 - 2 * part;
  if (bench.drag == DragKind::kThreshold)
    state.look = withThreshold(state.look, bench.threshold + up * (range[1] - range[0]) / 4);
  else
    state.view = orbit(state.view, part <= 0.5 ? 4 : -4, 0, {bench.width, bench.height});
}

// Opens the volume and waits for the first picture, then drags the threshold or turns the view back
// and forth with a hand's events, lets go, and waits for the whole picture:
// {"first_picture_seconds", "answer_seconds": {"p50", "p95", "max"}, "complete_seconds",
// "steady_frame_seconds", "loop_seconds": {"p50", "p95", "max"}, ...}. The first picture's seconds
// count from the call. The loop's times are those of one turn of the thread that stands for the
// window's, which asks and takes. Throws Error.
nlohmann::json benchView(const ViewBench& bench) {
  const Stopwatch since_start;
  DrawingThread desk(bench.drawing);
  Loop loop(desk);
  desk.open(bench.volume, std::nullopt);
  {
    constexpr uint64_t kTotal = 1000;
    const ProgressWatch opening = progressLine("opening", ProgressUnit::kShare);
    loop.turnUntil([&] {
      if (opening) opening(static_cast<uint64_t>(kTotal * desk.status().share), kTotal);
      return loop.opened != nullptr;
    });
  }
  const std::array<double, 2> range = loop.opened->info.value_range;
  Wish wish;
  wish.state = loop.opened->state;
  wish.width = bench.width;
  wish.height = bench.height;
  const auto whole = [&] {
    const Stopwatch watch;
    // The hand lets go: a whole picture is drawn now, not previews.
    wish.moves = false;
    const uint64_t number = loop.wish(wish);
    loop.turnUntil([&] { return loop.completed >= number; });
    return watch.seconds();
  };
  if (bench.drag == DragKind::kThreshold)
    wish.state.look = withThreshold(wish.state.look, bench.threshold);
  loop.wish(wish);
  loop.turnUntil([&] { return loop.picture != nullptr; });
  const double first_s = since_start.seconds();
  whole();
  const double first_whole_s = since_start.seconds();
  // Steady: nothing is loaded, the camera alone moves.
  std::vector<double> steady;
  for (int i = 0; i < 9; ++i) {
    wish.state.view = orbit(wish.state.view, 1, 0, {bench.width, bench.height});
    whole();
    steady.push_back(loop.picture->seconds);
  }
  const size_t answers_before = desk.times().answer_s.size();
  const uint64_t pictures_before = desk.times().previews + desk.times().complete;
  std::vector<double> complete;
  const std::chrono::duration<double> apart(1 / bench.events_per_second);
  for (int drag = 0; drag < bench.drags; ++drag) {
    auto due = Clock::now();
    for (int i = 1; i <= bench.events; ++i) {
      move(wish.state, bench, range, i);
      wish.moves = true;
      loop.wish(wish);
      due += std::chrono::duration_cast<Clock::duration>(apart);
      loop.turnUntil(due);
    }
    complete.push_back(whole());
  }
  const DeskTimes times = desk.times();
  // Answers to the wishes before the drags count among the first pictures.
  std::vector<double> answers(times.answer_s.begin() + static_cast<std::ptrdiff_t>(answers_before),
                              times.answer_s.end());
  const double steady_s = median(steady);
  return {{"events", answers.size()},
          {"pictures", times.previews + times.complete - pictures_before},
          {"drag", bench.drag == DragKind::kThreshold ? "threshold" : "view"},
          {"first_picture_seconds", first_s},
          {"first_complete_seconds", first_whole_s},
          {"levels", loop.picture->levels},
          {"answer_seconds", spread(std::move(answers))},
          {"steady_frame_seconds", steady_s},
          {"complete_seconds", spread(complete)},
          {"complete_frames", median(complete) / steady_s},
          {"loop_seconds", spread(loop.turn_s)},
          {"cancelled", times.cancelled},
          {"peak_rss_bytes", peakResidentBytes()},
          {"device", loop.opened->device}};
}

// Warns of options that change nothing in the pictures.
void warnOfIdle(const std::set<std::string>& given, const ViewBench& bench) {
  const bool is_of_picture = std::ranges::any_of(optionTable(), [&](const OptionEntry& entry) {
    return std::ranges::any_of(optionNames(entry), [&](std::string_view name) {
      return given.contains(std::string(name));
    });
  });
  if (!is_of_picture) return;
  VolumeOptions options = bench.volume.options;
  if (options.index_folder.empty()) options.index_folder = bench.drawing.index_folder;
  const ViewState& state = bench.drawing.state;
  Renderer renderer(Volume(bench.volume.paths, options), lookOf(state), bench.drawing.renderer);
  for (const std::string& line :
       renderer.idleOptions(given, pictureOf(state, bench.width, bench.height)))
    printWarning(fmt::format("{}: {}", bench.volume.paths.front(), line));
}

void printView(const nlohmann::json& report) {
  const auto ms = [](const nlohmann::json& seconds) { return 1e3 * seconds.get<double>(); };
  const auto& answer = report["answer_seconds"];
  const auto& loop = report["loop_seconds"];
  say("first picture {:.0f} ms after the start, the whole one after {:.0f} ms\n",
      ms(report["first_picture_seconds"]), ms(report["first_complete_seconds"]));
  say("{} events of dragging the {}, {} pictures on {}\n", report["events"].get<size_t>(),
      report["drag"].get<std::string>(), report["pictures"].get<uint64_t>(),
      report["device"].get<std::string>());
  say("from an event to its picture: p50 {:.1f} ms, p95 {:.1f} ms, max {:.1f} ms\n",
      ms(answer["p50"]), ms(answer["p95"]), ms(answer["max"]));
  say("whole picture after letting go: {:.1f} ms, {:.2f} steady frames of {:.1f} ms\n",
      ms(report["complete_seconds"]["p50"]), report["complete_frames"].get<double>(),
      ms(report["steady_frame_seconds"]));
  say("a turn of the loop: p95 {:.3f} ms, max {:.3f} ms\n", ms(loop["p95"]), ms(loop["max"]));
}

}  // namespace

Bench addWindowBench(CLI::App& app) {
  auto bench = std::make_shared<BenchArguments>();
  auto events = std::make_shared<int>(120);
  auto drag = std::make_shared<DragKind>(DragKind::kThreshold);
  CLI::App* view = app.add_subcommand(
      "view", std::string("Measures the first picture and a drag without a window: from an event "
                          "to its picture, and whether the loop ever waits\n\n"
                          "Pictures are those of the window: lit unless --no-shade is given. "
                          "Without --threshold the drag begins at 0.\n\n") +
                  "  sluice bench view bonsai.nii.gz --threshold 40 --size 800x600");
  const AskedView options = addPictures(*view, *bench);
  const OptionGroup output(*view, kOutputHeading);
  output.number("--events", "N", *events, {2, 100'000}, "Events of each of three drags");
  output.choice("--drag",
                Words<DragKind>{{"threshold", DragKind::kThreshold}, {"view", DragKind::kView}},
                *drag, "What the hand moves");
  return {view,
          [bench, events, drag, options](const Show& show) {
            const ViewState state = viewState(*options, bench->volume, bench->look);
            const IndexWish wish = indexWish(bench->resources.index_dir);
            ViewBench asked;
            if (!wish.disabled) asked.drawing.index_folder = wish.folder.string();
            asked.volume = viewedVolume(bench->volume, bench->resources, asked.drawing.index_folder,
                                        !bench->look.this_step);
            asked.drawing.renderer = rendererOptions(bench->resources);
            asked.drawing.state = state;
            asked.width = bench->frame.size.width;
            asked.height = bench->frame.size.height;
            asked.threshold = bench->look.threshold.value_or(0);
            asked.events = *events;
            asked.drag = *drag;
            const nlohmann::json report = benchView(asked);
            // Afterwards, since the bench opens the volume by itself.
            warnOfIdle(givenOptions(*bench->app), asked);
            return show(report, printView);
          },
          true};
}

}  // namespace sluice

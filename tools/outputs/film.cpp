#include "tools/outputs/film.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sluice/renderer.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/options/idle_options.h"
#include "src/options/option_rules.h"
#include "src/view/drawing/picture_file.h"
#include "src/view/state/view_check.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/outputs.h"
#include "tools/command_line/progress_line.h"
#include "tools/command_line/usage.h"
#include "tools/commands/commands.h"
#include "tools/commands/render_checks.h"
#include "tools/options/view_arguments.h"
#include "tools/outputs/film_file.h"
#include "tools/scene/empty_pictures.h"

namespace sluice {
namespace {

// Options outside of the tables that frames of a path take: they say what is read and written, and
// with which part of the machine. All others are about how one picture is drawn or reported.
constexpr std::array<std::string_view, 14> kOfFrames{
    "--size",    "--output", "--state",  "--rate",      "--frames", "--force",     "--continue",
    "--threads", "--device", "--memory", "--index-dir", "--cache",  "--cache-dir", "--quiet"};

bool framesTake(std::string_view name) {
  const auto is_called = [&](const auto& entry) {
    return entry.option == name || entry.kind.needs == name ||
           std::ranges::count(entry.kind.flags, name) > 0;
  };
  return std::ranges::count(kOfFrames, name) > 0 || std::ranges::any_of(volumeTable(), is_called) ||
         std::ranges::any_of(optionTable(), [&](const OptionEntry& entry) {
           // --fit is about the view of one picture, too.
           return entry.part != OptionPart::kPicture && entry.option != "--fit" && is_called(entry);
         });
}

void checkOptions(const RenderArguments& arguments, const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string name = "--" + option->get_lnames().front();
    if (!framesTake(name))
      fail("{}: frames of the path in {} do not take it; {} for one picture", name,
           arguments.state_file,
           app.count("--frames") > 0 ? "leave out --frames" : "give -o a name without a number");
  }
}

// A way to give opacities takes the place of the others.
void replaceOpacities(LookOptions& look, const LookOptions& given) {
  look.opacities = given.opacities;
  look.transfer_file = given.transfer_file;
  look.labels = given.labels;
  look.threshold = given.threshold;
}

// The state of a key or a frame with the user's options in place of its own. One option of the
// camera replaces all of it.
ViewState withGiven(const SavedFilm& film, const ViewState& now, ViewState state) {
  for (const OptionEntry* given : film.given) {
    if (given->part == OptionPart::kCamera)
      state.view = now.view;
    else if (givesOpacities(*given))
      replaceOpacities(state.look, now.look);
    else
      given->set(state, given->get(now).value());
  }
  return state;
}

ViewState frameState(const SavedFilm& film, const ViewState& now, int64_t frame) {
  const ViewState state = stateAt(film.path, now, frame);
  // A turn is made from the given options.
  return film.path.kind == ViewPath::Kind::kTurn ? state : withGiven(film, now, state);
}

std::string namesOf(const std::vector<const OptionEntry*>& given) {
  std::vector<std::string_view> names;
  names.reserve(given.size());
  for (const OptionEntry* entry : given) names.push_back(entry->option);
  return fmt::format("{}", fmt::join(names, ", "));
}

// Throws Error if the user's options take the place of everything that changes along the path, so
// that all frames would be one picture. Otherwise warns of a camera that stops the path's.
void requireMotion(const SavedFilm& film, const ViewState& now, const std::string& file,
                   bool is_quiet) {
  if (film.path.kind == ViewPath::Kind::kTurn || film.given.empty()) return;
  const std::vector<ViewKey>& keys = film.path.keys;
  const auto differs = [&](const auto& valueOf) {
    return std::ranges::any_of(
        keys, [&](const ViewKey& key) { return valueOf(key) != valueOf(keys.front()); });
  };
  if (differs([](const ViewKey& key) { return key.state; }) &&
      !differs([&](const ViewKey& key) { return withGiven(film, now, key.state); }))
    fail(
        "{}: with {} in place of the path's own values, all of its frames are the same; give fewer "
        "options, or give -o a name without a number for one picture",
        file, namesOf(film.given));
  const auto is_camera = [](const OptionEntry* given) {
    return given->part == OptionPart::kCamera;
  };
  std::vector<const OptionEntry*> camera;
  std::ranges::copy_if(film.given, std::back_inserter(camera), is_camera);
  if (!is_quiet && !camera.empty() && differs([](const ViewKey& key) { return key.state.view; }))
    printWarning(fmt::format("{}: {}: one camera shows all frames, in place of the path's cameras",
                             file, namesOf(camera)));
}

// Warns of numbers that jump along the path. Those of the user's options do not.
void warnOfJumps(const SavedFilm& film, const ViewState& now, const std::string& file) {
  ViewPath path = film.path;
  for (ViewKey& key : path.keys) key.state = withGiven(film, now, std::move(key.state));
  if (const auto jumps = jumpsAlong(path)) printWarning(fmt::format("{}: {}", file, *jumps));
}

// Throws Error, which names the key, for a look that the volume cannot have, such as a file that is
// missing: before the first frame is written.
void requireLooks(const SavedFilm& film, const ViewState& now, Renderer& renderer,
                  const std::string& file) {
  const std::vector<ViewKey>& keys = film.path.keys;
  if (film.path.kind == ViewPath::Kind::kTurn) return;
  for (size_t i = 0; i < keys.size(); ++i) try {
      if (i == 0 || keys[i].state.look != keys[i - 1].state.look)
        renderer.setLook(lookOf(withGiven(film, now, keys[i].state)));
    } catch (const Error& error) {
      failAs(error.kind(), "{}: {}: {}", file, keyPlace(i), error.what());
    }
}

// Warns of options that change nothing in any key frame, or in a turn: between key frames the words
// of the earlier one hold.
void warnOfIdleOptions(const SavedFilm& film, const ViewState& now, std::set<std::string> given,
                       const RenderArguments& arguments, Renderer& renderer) {
  given.erase("--rate");  // judged by checkArguments()
  std::vector<ViewState> states;
  if (film.path.kind == ViewPath::Kind::kTurn) states.push_back(now);
  for (const ViewKey& key : film.path.keys)
    if (film.path.kind == ViewPath::Kind::kKeys) states.push_back(withGiven(film, now, key.state));
  std::optional<std::vector<std::string>> lines;
  for (const ViewState& state : states) {
    renderer.setLook(lookOf(state));
    const std::vector<std::string> idle = renderer.idleOptions(
        given, pictureOf(state, arguments.frame.size.width, arguments.frame.size.height));
    if (!lines)
      lines = idle;
    else
      std::erase_if(*lines,
                    [&](const std::string& line) { return std::ranges::count(idle, line) == 0; });
  }
  for (const std::string& line : lines.value_or(std::vector<std::string>()))
    printWarning(fmt::format("{}: {}", arguments.volume.inputs.front(), line));
}

// Has the path pass in so many frames, at equal times from its beginning to its end. Throws Error
// if it takes no time.
void spreadFrames(int64_t frames, const std::string& file, ViewPath& path) {
  if (path.kind == ViewPath::Kind::kTurn) {
    path.turn_frames = frames;
    return;
  }
  if (frames > 1 && !(secondsOf(path) > 0))
    fail("{}: the saved path has one key frame, and so one picture; leave out --frames", file);
  // Any rate of less than a frame gives the first one.
  const double steps = frames > 1 ? static_cast<double>(frames - 1) : 0.5;
  if (secondsOf(path) > 0) path.frames_per_second = steps / secondsOf(path);
}

std::vector<int64_t> missingFrames(const RenderArguments& arguments, int64_t frames) {
  std::vector<int64_t> missing;
  for (int64_t i = 0; i < frames; ++i)
    if (!arguments.resume || !isDrawn(arguments, numberedName(arguments.output, i, true)))
      missing.push_back(i);
  return missing;
}

void checkOutputs(const RenderArguments& arguments, const SavedFilm& film,
                  const std::vector<int64_t>& frames, const std::vector<std::string>& more_read) {
  Outputs outputs(arguments.force);
  outputs.reads(arguments.volume.inputs);
  outputs.reads({arguments.look.transfer_file, arguments.state_file});
  for (const ViewKey& key : film.path.keys) outputs.reads(key.state.look.transfer_file);
  const FileKind kind =
      pictureKind(arguments.output) == PictureKind::kExr ? FileKind::kExr : FileKind::kPng;
  if (isFilmName(arguments.output))
    outputs.writes("-o", arguments.output, FileKind::kFilm);
  else
    for (const int64_t i : frames)
      outputs.writes("-o", numberedName(arguments.output, i, true), kind);
  outputs.check(more_read);
}

void addFrame(FilmFile& film, Renderer& renderer, const ViewState& state,
              const PictureOptions& options, const ProgressFunction& watch) {
  renderer.drawRows(
      options,
      [&](const Image& few) {
        const Picture rows{few.width, few.height, few.rgba, {}};
        film.add(state.background ? over(rows, *state.background) : rows);
      },
      watch);
}

void checkArguments(const RenderArguments& arguments, const CLI::App& app) {
  checkOptions(arguments, app);
  const bool is_one_file = isFilmName(arguments.output);
  if (!is_one_file) requirePictureName(arguments.output);
  if (is_one_file && arguments.resume)
    failUsage("{}: a film is written in one go; --continue is for pictures", arguments.output);
  if (app.count("--rate") == 0 || arguments.resources.quiet) return;
  PictureFacts facts;
  facts.is_film = is_one_file;
  for (const std::string& line : idleOptions({"--rate"}, facts)) printWarning(line);
}

// Draws the frames to the film, or to a picture each.
void writeFrames(const RenderArguments& arguments, const SavedFilm& film, const ViewState& now,
                 const std::vector<int64_t>& frames, std::optional<FilmFile>& made,
                 Renderer& renderer, const ProgressFunction& watch) {
  const bool is_quiet = arguments.resources.quiet;
  const int width = arguments.frame.size.width, height = arguments.frame.size.height;
  ProgressMeter progress = is_quiet ? ProgressMeter()
                                    : ProgressMeter(progressLine("frames", ProgressUnit::kPieces),
                                                    static_cast<uint64_t>(frames.size()));
  EmptyPictures empty;
  for (const int64_t i : frames) {
    interruption().throwIfStopped();
    const ViewState state = frameState(film, now, i);
    renderer.setLook(lookOf(state));
    const std::string name =
        made ? fmt::format("frame {}", i) : numberedName(arguments.output, i, true).string();
    if (made)
      addFrame(*made, renderer, state, pictureOf(state, width, height), watch);
    else
      drawToFile(renderer, name, state, width, height, watch, {});
    empty.add(name, renderer.report().why_empty);
    progress.add(1);
  }
  if (made) made->finish();
  if (!is_quiet) empty.warn();
}

}  // namespace

bool asksForFilm(const RenderArguments& arguments) {
  return (isNumbered(arguments.output) || isFilmName(arguments.output) || arguments.frames > 1) &&
         !arguments.times && arguments.path_file.empty();
}

int writeFilm(const RenderArguments& arguments, const CLI::App& app, const SavedView& saved,
              const std::set<std::string>& given) {
  SavedFilm film = *saved.film;
  checkArguments(arguments, app);
  const double saved_rate = film.path.frames_per_second;
  if (given.contains("--frames")) spreadFrames(arguments.frames, arguments.state_file, film.path);
  const bool is_one_file = isFilmName(arguments.output);
  const int64_t count = frameCount(film.path);
  const std::vector<int64_t> frames = missingFrames(arguments, count);
  // Outputs are checked once more with the files that the volume turns out to have.
  checkOutputs(arguments, film, frames, {});
  const bool is_quiet = arguments.resources.quiet;
  if (frames.empty()) {
    if (!is_quiet) say("all {} frames are there\n", count);
    return kDone;
  }
  sayKept(arguments, count - static_cast<int64_t>(frames.size()), count, Comparison::kNone);
  const IndexWish wish = indexWish(arguments.resources.index_dir);
  ViewedVolume viewed =
      viewedVolume(arguments.volume, arguments.resources, wish.disabled ? "" : wish.folder.string(),
                   !arguments.look.this_step);
  viewed.options.web = webOf(arguments.volume.open.web, namesOf(viewed));
  viewed.options.time = 0;  // the view's own is checked against the volume first
  // A signal ends whatever is under way.
  const auto watch = [](const Progress&) { interruption().throwIfStopped(); };
  viewed.options.opens_soon = true;  // as the window does
  const Volume volume(viewed.paths, viewed.options, watch);
  saved.requireFits(volume.info());
  checkOutputs(arguments, film, frames, volume.info().files);
  if (!is_quiet) {
    for (const std::string& warning : volume.info().warnings) printWarning(warning);
    for (const std::string& note : saved.notes()) printWarning(note);
  }
  ViewState now = viewState(*arguments.asked, arguments.volume, arguments.look);
  const int width = arguments.frame.size.width, height = arguments.frame.size.height;
  RendererOptions options = rendererOptions(arguments.resources);
  options.rows_width = width;
  options.rows_height = height;
  Renderer renderer(volume, now.look, options);
  if (!now.view.look_at || !now.view.up)
    now.view = renderer.placed(pictureOf(now, width, height), watch);
  placeKeys(film.path, renderer, watch);
  requireMotion(film, now, arguments.state_file, is_quiet);
  requireLooks(film, now, renderer, arguments.state_file);
  if (!is_quiet) {
    warnOfIdleOptions(film, now, given, arguments, renderer);
    warnOfJumps(film, now, arguments.state_file);
  }
  std::optional<FilmFile> made;
  const std::string note = is_one_file ? filmSizeNote(arguments.output, arguments.frame.size) : "";
  if (!note.empty() && !is_quiet) printWarning(note);
  if (is_one_file)
    made.emplace(arguments.output, arguments.frame.size,
                 app.count("--rate") > 0 ? arguments.frames_per_second : saved_rate,
                 interruption());
  writeFrames(arguments, film, now, frames, made, renderer, watch);
  if (is_one_file && !is_quiet) say("{}: {} frames\n", arguments.output, count);
  if (!is_one_file && !is_quiet)
    say("{} of {} frames, {} to {}\n", frames.size(), count,
        numberedName(arguments.output, frames.front(), true).string(),
        numberedName(arguments.output, frames.back(), true).string());
  return kDone;
}

}  // namespace sluice

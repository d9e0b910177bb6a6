// WindowState: everything that a window keeps between two of its frames: the history of what is
// shown, the desk's last news, and what the user is doing. Plain values, one for each thing, and
// functions that update them. Panels (panels/panels.h) read it, draw themselves, and change the
// view through change(). One thread, the window's.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/view/drawing/desk.h"
#include "src/view/drawing/window_module.h"
#include "src/view/state/editing/camera_gestures.h"
#include "src/view/state/editing/history.h"
#include "src/view/state/files/folder_list.h"
#include "src/view/state/files/settings.h"
#include "src/view/window/event_log.h"
#include "src/view/window/texture.h"

namespace sluice {

using WindowClock = std::chrono::steady_clock;

struct WindowState;

// The volume that is open, as the desk described it.
struct OpenVolume {
  std::unique_ptr<OpenedVolumeNews> news;  // null: none is open
  Ground ground;
  ShownLook look;
  RenderReport report;
};

// The pixels go into the texture; if the processor would have to filter it, they stay with the
// picture for the canvas. A finer picture of the same view fades in over the coarser one.
struct PictureOnScreen {
  ShownPicture picture;
  Texture texture;
  Texture before;  // texture of the coarser picture, while one fades
  bool keeps_pixels = false;
  bool is_new = false;                                   // since the window was last presented
  std::optional<WindowClock::time_point> faded_in_from;  // unset: nothing fades
  double share = 1;  // share of the picture in this turn, the rest is the coarser one's
};

struct SliceOnScreen {
  Texture texture;
  int64_t at = -1, time = -1;
  SliceValues values;
  bool is_new = false;
};

// The pointer's current gesture, and what is known of the place where it rests.
struct Pointer {
  enum class Does { kNothing, kOrbit, kPan, kRoll, kWindow, kLook, kHandle };
  Does does = Does::kNothing;
  bool is_down = false;                   // a button is held
  int handle = -1;                        // handle of the clip box
  double handle_rest = 0;                 // parts of a voxel that it was dragged
  std::optional<size_t> point;            // the opacity point that is dragged
  std::vector<PanePoint> steps;           // movements of this frame, screen units
  float x = -1, y = -1;                   // place where it rests
  WindowClock::time_point still_since{};  // or no time: the value there was asked for
  std::optional<uint64_t> question;       // number of the newest, while its answer is of use
  bool centers = false;                   // the answer is to come to the middle
  std::optional<VoxelProbe> value;
  std::optional<VoxelProbe> slice_value;  // while it is over a slice
};

// Key frames or a turn; while a frame is shown instead, `view` keeps the user's own view.
struct FilmEditor {
  ViewPath path;
  std::string name = "frame_%04d.png";
  std::optional<ViewState> view = {};
  int64_t frame = 0;
  bool is_playing = false;
  bool removes_key = false;  // when the view is fitted
  WindowClock::time_point began{};
};

// Time steps one after the other, each as soon as the last one was seen.
struct SeriesPlayer {
  bool is_playing = false;
  double steps_per_second = 8;
  double achieved_steps = 0;  // a second, while it plays
  WindowClock::time_point step_at{};
};

// The state of the panels, and the text typed into them.
struct PanelChoices {
  bool is_log_histogram = true;
  bool shows_help = false, shows_open = false, shows_maps = false, shows_axes = true;
  std::map<std::string, double> hidden_opacities;  // of channels, from before they were hidden
  std::string transfer_file, picture_file = "picture.png", state_file = "view.json";
};

struct Messages {
  std::deque<std::string> lines;      // for people, the last one first
  std::vector<std::string> failures;  // shown until they are closed
  std::string saved;                  // over the picture, until `saved_until`
  WindowClock::time_point saved_until{};
};

// The wishes sent to the desk.
struct SentWishes {
  std::optional<Wish> last;
  uint64_t number = 0;  // number of `last`
  std::deque<std::pair<uint64_t, WindowClock::time_point>> unanswered;
};

// An action of the user that waits for a fit.
struct WaitingAct {
  std::function<void(WindowState&)> act;
  std::string loss;  // "view.json is not saved", if the act is dropped; empty: nothing to tell
};

// A view that the desk fits to the volume. The camera and everything that uses it wait for it, so
// that they follow from the view that was asked for.
struct Fit {
  uint64_t number = 0;
  WindowClock::time_point asked_at{};
  std::vector<WaitingAct> waiting;  // in the order of the user's actions
};

// Measurements of the window's own loop.
struct LoopTimes {
  uint64_t turns = 0;
  // Seconds of the loop's turns without the wait for events, and the share of OpenGL in them.
  std::vector<double> turn_s, gl_s;
  uint64_t stalls = 0;  // turns of more than 20 ms
  uint64_t events = 0;  // events of mouse, keys and window
  uint64_t gl_errors = 0;
  std::vector<double> answer_s;  // from an event to its new picture on the screen
};

struct LoopClock {
  // A frame is due then, whatever happens: the earliest that was asked for.
  std::optional<WindowClock::time_point> wake_at;
  WindowClock::time_point event_at{};   // time of the newest event
  WindowClock::time_point moved_at{};   // when something was last changed
  WindowClock::time_point nudged_at{};  // by the wheel or a key: more may follow
  double showing_s = 0;                 // processor time to show a picture
  LoopTimes times;

  // Asks for a frame at this time or earlier.
  void wakeBy(WindowClock::time_point then) {
    if (!wake_at || then < *wake_at) wake_at = then;
  }
};

// The window that opens files: a folder at a time, read on a thread of its own.
struct FolderDialog {
  explicit FolderDialog(std::function<void()> on_list) : reader(std::move(on_list)) {}
  FolderReader reader;
  FolderList list;  // the list that is shown
  std::optional<FolderQuestion> asked;
  std::string typed;  // a name, or part of one
  int selected = -1;  // index among the entries that are shown
  bool joins_series = true;
  bool was_shown = false;
};

struct WindowState {
  // `wake`: makes the window look again, from any thread.
  WindowState(const WindowRequest& request, const std::function<void()>& wake);

  const ViewState& state() const { return history.now(); }
  bool isOpen() const { return volume.news != nullptr; }
  const VolumeInfo& info() const { return volume.news->info; }
  std::array<double, 2> valueRange() const { return info().value_range; }
  // Changes what is shown. Changes while one button is held, or within a moment of wheel and keys,
  // are one step of the history. A number that cannot be drawn is a failure and no change.
  void change(const ViewState& next);
  // Changes the current state by `edit`.
  template <class Edit>
  void edit(const Edit& edit) {
    ViewState next = state();
    edit(next);
    change(next);
  }
  // Does act(*this), which uses the camera: at once, or when the view that was asked for is fitted.
  // `loss`: see WaitingAct.
  template <class Act>
  void afterFit(Act act, const std::string& loss = {}) {
    if (fit)
      fit->waiting.push_back(WaitingAct{std::move(act), loss});
    else
      act(*this);
  }
  // Changes the camera: `move` makes a view of a view.
  template <class Move>
  void moveView(Move move) {
    afterFit([move = std::move(move)](WindowState& window) {
      window.edit([&](ViewState& next) { next.view = move(next.view); });
    });
  }
  // A line for people, here and on standard output.
  void say(const std::string& line);
  void fail(const std::string& line);

  const WindowRequest& request;
  Desk& desk;
  EventLog log;
  Settings settings;
  History<ViewState> history;
  int gesture = 1;  // number of the step that changes belong to
  OpenVolume volume;
  DeskStatus status;
  PictureOnScreen shown;
  std::array<SliceOnScreen, 3> slices;
  Pane pane;  // pixels
  Pointer pointer;
  FilmEditor film;
  SeriesPlayer series;
  PanelChoices panels;
  Messages messages;
  SentWishes wishes;
  std::optional<Fit> fit;
  LoopClock loop;
  FolderDialog dialog;
  bool wants_to_end = false;
};

// Actions of the user on files and views.
// Opens a file of a state or of a volume, depending on the name.
void openAny(WindowState& window, const std::vector<std::string>& paths);
void loadState(WindowState& window, const std::string& name);
void savePicture(WindowState& window, const std::string& path);
void saveState(WindowState& window, const std::string& name);
// Fits the volume into a view from the named side; the desk places the camera.
void showFrom(WindowState& window, ViewOptions::From from);
// Ends a fit without a view, and with it what waits, which would use another view than the user
// asked for. Returns a line for each loss, which gives the reason.
std::vector<std::string> dropFit(WindowState& window, const std::string& why);
void toggleProjection(WindowState& window);
// Cuts off everything between the eye and the target.
void cutHere(WindowState& window);
void undo(WindowState& window);
void redo(WindowState& window);

// Takes the news of the desk (desk_news.cpp).
void takeNews(WindowState& window);
// Decides how much of a picture that fades in is shown in this turn.
void updateFade(WindowState& window);
// All that was taken is on the screen now: its times are known, and a fade may be over.
void notePresented(WindowState& window);
// Tells the desk which picture is wanted, if that has changed.
void sendWish(WindowState& window);
// Whether the view that is wanted could not be drawn.
bool hasFailed(const WindowState& window);
// The text for the picture's corner: why the picture is not complete yet, or why a complete one
// shows nothing; and of a volume with levels of resolution, the levels that are shown and whether
// they will get finer. Empty for a complete picture of one level that shows something.
struct CornerText {
  std::string text;
  bool is_final = false;  // nothing will change by itself
};
CornerText cornerText(const WindowState& window);

// The film and the series (playing.cpp). A frame takes the place of the view, which comes back when
// the film ends; any change of the view ends it.
void addKey(WindowState& window);
void playFilm(WindowState& window);  // or ends it
void showFrame(WindowState& window, int64_t frame);
void endFilm(WindowState& window);
void showPlayedFrame(WindowState& window);  // the frame that is due
void writeFilm(WindowState& window);        // or cancels
// The next step of a series that plays, when the last one was seen.
void playSeries(WindowState& window);

}  // namespace sluice

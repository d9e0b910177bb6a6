// Sitting: all that a window has in hand between two of its frames: the history of what is shown,
// what the desk said last, and what the user is doing. Panels (one function each, panels.h) read
// it, draw themselves, and change the state through change(). One thread, the window's.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/view/camera_gestures.h"
#include "src/view/desk.h"
#include "src/view/folder_list.h"
#include "src/view/history.h"
#include "src/view/settings.h"
#include "src/view/window/event_log.h"
#include "src/view/window/texture.h"
#include "src/view/window_module.h"

namespace sluice {

using WindowClock = std::chrono::steady_clock;

// What was measured of the window's own loop.
struct LoopTimes {
  uint64_t turns = 0;
  // Turns of the loop, waiting for events not counted, and what of them OpenGL took.
  std::vector<double> turn_s, gl_s;
  uint64_t stalls = 0;  // turns of more than 20 ms
  uint64_t events = 0;  // of mouse, keys and window
  uint64_t gl_errors = 0;
  std::vector<double> answer_s;  // from an event to its new picture on the screen
};

// What the pointer is doing with the picture.
struct Hand {
  enum class Does { kNothing, kOrbit, kPan, kRoll, kWindow, kLook, kHandle };
  Does does = Does::kNothing;
  int handle = -1;                        // of the clip box
  float x = -1, y = -1;                   // where it rests
  WindowClock::time_point still_since{};  // or nothing: it was asked what is there
};

// The window that opens files: a folder at a time, read on a thread of its own.
struct FolderDialog {
  explicit FolderDialog(std::function<void()> on_list) : reader(std::move(on_list)) {}
  FolderReader reader;
  FolderList list;  // that is shown
  std::optional<FolderQuestion> asked;
  std::string typed;  // a name, or part of one
  int selected = -1;  // of the entries that are shown
  bool joins_series = true;
  bool was_shown = false;
};

class Sitting {
 public:
  // `wake`: makes the window look again, from any thread.
  Sitting(const WindowRequest& request, const std::function<void()>& wake);

  // What is shown from now on. Changes while one button is held, or within a moment of wheel and
  // keys, are one step of the history.
  void change(const ViewState& next);
  // A button was pressed: what follows is a step of its own.
  void beginGesture() { ++gesture_; }
  const ViewState& state() const { return history.now(); }
  bool isOpen() const { return opened != nullptr; }
  const VolumeInfo& info() const { return opened->info; }
  std::array<double, 2> valueRange() const { return opened->info.value_range; }

  void open(const std::string& path);
  // A state's file or a volume, as its name says.
  void openAny(const std::vector<std::string>& paths);
  void savePicture(const std::string& path);
  void saveState(const std::string& name);
  // Fitted, from where its name says; the desk places it.
  void showFrom(ViewOptions::From from);
  void toggleProjection();
  void takeNews();
  // All that was taken is on the screen now: its times are known.
  void notePresented();
  // A wish has no picture yet.
  bool awaitsPicture() const { return !unanswered_.empty(); }
  // Tells the desk what is to be seen, where that is something else than last time.
  void sendWish();
  void say(const std::string& line);
  // The picture is not the whole one yet: why, in words for its corner; empty: it is.
  std::string incompleteText() const;
  // The next step of a series that plays, when the last one was seen.
  void play();

  // The film: what is shown of it takes the place of the view, which comes back when it ends. Any
  // change of the view ends it.
  void addKey();
  void playFilm();  // or ends it
  void showFrame(int64_t frame);
  void endFilm();
  void showPlayedFrame();  // that is due
  void writeFilm();        // or cancels
  bool hasFilm() const { return frameCount(film) > 0; }

  const WindowRequest& request;
  Desk& desk;
  EventLog log;
  Settings settings;

  History<ViewState> history;
  std::unique_ptr<OpenedVolumeNews> opened;
  Ground ground;
  ShownLook look;
  RenderReport report;
  DeskStatus status;
  // Its pixels go into the texture, or, where the processor would have to filter that, stay with it
  // for the canvas.
  ShownPicture picture;
  bool keeps_pixels = false;
  Texture texture;
  std::array<Texture, 3> slices;
  // What was put into textures since the last notePresented().
  bool picture_is_new = false;
  std::array<bool, 3> slice_is_new{};
  std::array<int64_t, 3> slice_at{-1, -1, -1};
  std::optional<VoxelProbe> hovered;
  std::deque<std::string> messages;   // for people, the last one first
  std::vector<std::string> failures;  // shown until they are closed

  Pane pane;  // pixels
  Hand hand;
  bool hand_is_on = false;  // a button is held
  // A frame is due then, whatever happens: the earliest that was asked for.
  std::optional<WindowClock::time_point> wake_at;
  void wakeBy(WindowClock::time_point then) {
    if (!wake_at || then < *wake_at) wake_at = then;
  }
  WindowClock::time_point event_at{};  // of the newest event
  WindowClock::time_point moved_at{};  // when something was last changed
  double showing_s = 0;                // that the processor takes to show a picture
  ViewPath film;
  std::string film_text = "frame_%04d.png";
  std::optional<ViewState> film_from;  // the view while a frame is shown in its place
  int64_t film_frame = 0;
  bool is_film_playing = false;
  WindowClock::time_point film_began{};
  bool is_playing = false;
  double steps_per_second = 8;
  double achieved_steps = 0;  // a second, while it plays
  bool is_log_histogram = true;
  bool shows_help = false, shows_open = false, shows_maps = false, shows_axes = true;
  bool centers_on_probe = false;
  uint64_t probe_number = 0;  // of the question that was asked last
  std::optional<size_t> held_point;
  double handle_rest = 0;  // parts of a voxel that a handle was dragged
  FolderDialog dialog;
  std::string transfer_text, picture_text = "picture.png", state_text = "view.json";
  LoopTimes times;
  bool wants_to_end = false;

 private:
  void takeOpened(std::unique_ptr<OpenedVolumeNews> news);
  void takePicture(ShownPicture shown);
  void keepRecent();
  void takeVanished(const std::string& gone);

  int gesture_ = 1;
  std::optional<Wish> sent_;
  uint64_t sent_number_ = 0;
  int64_t seen_frames_ = 0;
  std::deque<std::pair<uint64_t, WindowClock::time_point>> unanswered_;
  // When the wheel or a key last changed something: more may follow, which a button's release ends.
  WindowClock::time_point nudged_at_{};
  WindowClock::time_point step_at_{};
};

}  // namespace sluice

// The window: GLFW's, with Dear ImGui's panels over a picture that the desk draws. Its loop waits
// for events and news, and for nothing else.
#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/view/drawing/window_module.h"
#include "src/view/state/screen/scaled_pixels.h"
#include "src/view/window/canvas.h"
#include "src/view/window/panels/panels.h"
#include "src/view/window/surface.h"

namespace sluice {
namespace {

constexpr float kPanelWidth = 330, kSlicesHeight = 240;  // screen units at a font scale of 1
// The first frames make fonts and shaders: they are measured apart.
constexpr uint64_t kStartTurns = 8;
constexpr size_t kMostTurns = size_t{1} << 18;
constexpr double kIdle_s = 0.25, kSettle_s = 0.004, kReport_s = 0.3, kStall_s = 0.02;
constexpr double kShowingMean = 8;  // pictures that the mean of their showing is of
// While a picture is on its way, panels drawn in software wait so long to come with it.
constexpr auto kWithPicture = std::chrono::milliseconds(33);

void chooseFont(float scale) {
  ImFontConfig config;
  config.OversampleH = 2;
  constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  std::error_code unknown;
  ImGuiIO& io = ImGui::GetIO();
  // ImGui's own font is a bitmap of 13 pixels, which scales badly.
  if (std::filesystem::exists(kFont, unknown)) {
    io.Fonts->AddFontFromFileTTF(kFont, std::round(14 * scale), &config);
  } else {
    config.SizePixels = std::round(13 * scale);
    io.Fonts->AddFontDefault(&config);
  }
}

// Times of one turn of the loop and of its parts.
struct TurnTimes {
  double news_s = 0, build_s = 0, wish_s = 0, gl_s = 0, all_s = 0;
};

double secondsSince(WindowClock::time_point then) {
  return std::chrono::duration<double>(WindowClock::now() - then).count();
}

class Window {
 public:
  explicit Window(const WindowRequest& request)
      : request_(request),
        state_(std::make_unique<WindowState>(request, [] { glfwPostEmptyEvent(); })) {
    const auto scale = static_cast<float>(request.settings.font_scale);
    window_ = makeWindow(request, kPanelWidth * scale);
    // All OpenGL of the window happens on this thread. The context must be current before the first
    // call, and hearDriver() comes first so that it hears the rest.
    glfwMakeContextCurrent(window_);
    hearDriver(*state_);
    is_software_ = drawsInSoftware();
    glfwSwapInterval(is_software_ ? 0 : 1);  // processors have no vertical blank
    // The canvas loads its functions from the current context, so it cannot be a member with an
    // initializer.
    canvas_.emplace();
    if (request.lend && (!is_software_ || request.lends_software))
      drawing_window_ = lendContext(request, window_);
    // The canvas scales the picture itself in software, once for each picture (updateBackdrop()).
    // OpenGL would filter the texture in each frame that draws it.
    state_->shown.keeps_pixels = is_software_;
    watchEvents(window_, events_);
    float density = 1, ignored = 1;
    glfwGetWindowContentScale(window_, &density, &ignored);
    ImGui::CreateContext();
    // ImGui would write imgui.ini into the working directory. Our own settings file has what is
    // kept.
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::StyleColorsDark();
    chooseFont(density);
    ImGui::GetStyle().ScaleAllSizes(density);
    density_ = density;
    ImGui_ImplGlfw_InitForOpenGL(window_, false);  // takeInput gives it the events
    ImGui_ImplOpenGL3_Init("#version 330");
    // The desk may wake the loop from here on. glfwPostEmptyEvent() is the one call of GLFW that
    // any thread may make for this.
    request.tell_news([] { glfwPostEmptyEvent(); });
  }
  ~Window() {
    // The order matters: no news may wake a window that is gone, and the desk ends before the
    // context that was lent to it. After run() it has ended already.
    request_.tell_news(nullptr);
    request_.end_desk();
    if (state_->log.isOn()) glDisable(GL_DEBUG_OUTPUT);  // it would report to the window
    state_.reset();                                      // its textures, while there is a context
    canvas_.reset();
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    if (drawing_window_ != nullptr) glfwDestroyWindow(drawing_window_);
    glfwDestroyWindow(window_);
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  void run() {
    // The volume opens while the window already answers: the desk has a thread of its own.
    if (!request_.volume.paths.empty()) request_.desk->open(request_.volume, std::nullopt);
    while (glfwWindowShouldClose(window_) == 0 && !state_->wants_to_end &&
           !request_.is_asked_to_end())
      turn();
    // A save that waits for a fit has not reached the desk yet, so that the desk cannot name it.
    for (const std::string& line : dropFit(*state_, "the window ended before its view was fitted"))
      state_->say(line);
    keepSettings();
    const DeskTimes desk = state_->desk.times();
    // From here on there is no desk. Its thread has ended when the lines come.
    for (const std::string& line : request_.end_desk()) {
      state_->say(line);
      state_->log.write({{"failure", line}});
    }
    logTimes(desk);
    if (const auto fault = state_->log.takeFault()) state_->say(*fault);
  }

 private:
  // Runs one frame of the window; it waits in its first line and nowhere else.
  void turn() {
    double wait_s = frames_left_ > 0 ? kSettle_s : kIdle_s;
    // Something is due at this time, such as the next frame of a film, which no event announces.
    if (state_->loop.wake_at)
      wait_s = std::clamp(
          std::chrono::duration<double>(*state_->loop.wake_at - WindowClock::now()).count(),
          kSettle_s, wait_s);
    // Events that one frame could not take belong to the next one, which does not wait.
    if (events_.input.isEmpty())
      glfwWaitEventsTimeout(wait_s);
    else
      glfwPollEvents();
    TurnTimes times;
    const auto began = WindowClock::now();
    WindowState& window = *state_;
    // Highlights and menus settle over a few frames.
    if (events_.count != seen_events_ || !events_.input.isEmpty()) frames_left_ = 2;
    if (events_.count != seen_events_) {
      window.loop.times.events += events_.count - seen_events_;
      seen_events_ = events_.count;
      window.loop.event_at = began;
    }
    // Each turn asks anew for the time at which it needs the next one.
    window.loop.wake_at.reset();
    if (frames_left_ > 0) --frames_left_;
    // News come before the panels are built, so that a picture is on the screen in the turn that
    // takes it. A drop may replace the volume that the news were of.
    takeNews(window);
    if (!events_.dropped.empty()) openAny(window, std::exchange(events_.dropped, {}));
    playSeries(window);
    showPlayedFrame(window);
    // The share of the fade belongs to this turn: the panels and the backdrop below draw the same
    // one.
    updateFade(window);
    times.news_s = secondsSince(began);
    build();
    times.build_s = secondsSince(began) - times.news_s;
    sendWish(window);
    askForReport(began);
    times.wish_s = secondsSince(began) - times.news_s - times.build_s;
    times.gl_s = present();
    times.all_s = secondsSince(began);
    note(times);
    // An echo tells that what came before it is on the screen, which is not so as long as the frame
    // is put off.
    if (events_.echoes > echoed_ && !is_put_off_) {
      echoed_ = events_.echoes;
      window.log.write({{"echo", echoed_}});
    }
    if (const auto fault = window.log.takeFault()) window.fail(*fault);
  }

  void note(const TurnTimes& turn) {
    LoopTimes& times = state_->loop.times;
    // Fonts, shaders and the first textures are made in these turns and would hide the longest
    // later one.
    if (++times.turns <= kStartTurns) {
      start_s_ = std::max(start_s_, turn.all_s);
      return;
    }
    if (times.turn_s.size() < kMostTurns) {
      times.turn_s.push_back(turn.all_s);
      if (turn.gl_s > 0) times.gl_s.push_back(turn.gl_s);
    }
    // Long turns are rare, and their parts tell which of them has waited.
    if (turn.all_s <= kStall_s) return;
    ++times.stalls;
    state_->log.write({{"long_turn_seconds", turn.all_s},
                       {"news_seconds", turn.news_s},
                       {"build_seconds", turn.build_s},
                       {"wish_seconds", turn.wish_s},
                       {"gl_seconds", turn.gl_s},
                       {"drawn_pixels", canvas_->drawnPixels()}});
  }

  void build() {
    WindowState& window = *state_;
    ImGui_ImplOpenGL3_NewFrame();
    // The order matters: takeInput() calls NewFrame() of the backend, which sets the size and time
    // of the frame, and ImGui::NewFrame() reads what both have set.
    takeInput(window_, events_, window);
    ImGuiIO& io = ImGui::GetIO();
    io.FontGlobalScale = static_cast<float>(window.settings.font_scale);
    ImGui::NewFrame();
    window.pointer.is_down = ImGui::IsAnyMouseDown();
    // A press begins a new step of undo, so that two drags in a row are taken back one by one.
    for (int button = 0; button < 3; ++button)
      if (ImGui::IsMouseClicked(button)) ++window.gesture;
    const float panel = std::min(kPanelWidth * density_ * io.FontGlobalScale, io.DisplaySize.x / 2);
    const bool has_slices = window.isOpen() && window.state().shows_slices;
    const float strip = has_slices ? std::min(kSlicesHeight * density_, io.DisplaySize.y / 2) : 0;
    const Area pane{0, 0, io.DisplaySize.x - panel, io.DisplaySize.y - strip};
    picturePane(window, pane, io.DisplayFramebufferScale.x);
    if (has_slices) slicesPane(window, {0, pane.height, pane.width, strip});
    sidePanel(window, {pane.width, 0, panel, io.DisplaySize.y});
    takeKeys(window);
    helpWindow(window);
    openWindow(window);
    failuresWindow(window);
    ImGui::Render();
  }

  // Draws and shows what differs from the screen. Returns the seconds that this took, 0 if nothing
  // did.
  double present() {
    WindowState& window = *state_;
    const auto began = WindowClock::now();
    is_put_off_ = false;
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    // A minimized window may have no pixels to draw to.
    if (width == 0 || height == 0) return 0;
    // The triangles are the same and the texture is not, which the comparison cannot see.
    if (window.shown.is_new) canvas_->noteRedrawn(window.shown.texture.id());
    if (is_software_) updateBackdrop();
    for (size_t axis = 0; axis < window.slices.size(); ++axis)
      if (window.slices[axis].is_new) canvas_->noteRedrawn(window.slices[axis].texture.id());
    ImDrawData& data = *ImGui::GetDrawData();
    const bool is_same = canvas_->compare(data, width, height).empty();
    // A frame that looks like the one on the screen costs nothing: no drawing and no swap.
    if (is_same && !window.shown.is_new && !events_.wants_refresh) return 0;
    const bool has_more = !events_.input.isEmpty();  // the next frame replaces this one at once
    // A frame of panels alone would take processor time from the picture that comes next, if OpenGL
    // is software.
    const bool awaits_picture =
        is_software_ && !window.shown.is_new && !window.wishes.unanswered.empty();
    if ((has_more || awaits_picture) && began - presented_at_ < kWithPicture) {
      is_put_off_ = true;
      window.loop.wakeBy(presented_at_ + kWithPicture);
      return 0;
    }
    canvas_->draw(data);
    // Bounded, since a lost context reports errors without end.
    while (glGetError() != GL_NO_ERROR && window.loop.times.gl_errors < 1'000'000)
      ++window.loop.times.gl_errors;
    glfwSwapBuffers(window_);
    // The flag is cleared after the swap, so that a frame that was put off still refreshes.
    events_.wants_refresh = false;
    presented_at_ = WindowClock::now();
    const double took = std::chrono::duration<double>(presented_at_ - began).count();
    // The desk gives previews this much less time (Wish::showing_s), because both share the
    // processors.
    if (is_software_ && window.shown.is_new)
      window.loop.showing_s += (took - window.loop.showing_s) / kShowingMean;
    notePresented(window);
    return took;
  }

  // The processor scales the pane's backdrop when OpenGL would do it in software.
  void updateBackdrop() {
    WindowState& window = *state_;
    const ShownPicture& picture = window.shown.picture;
    // A step that could not be drawn leaves the pane empty, as does a volume before its first
    // picture.
    if (!window.isOpen() || picture.rgba.empty()) return canvas_->dropBackdrop();
    const Pane& pane = window.pane;
    const bool is_same_pane = pane.width == shown_pane_.width && pane.height == shown_pane_.height;
    const bool is_new = window.shown.is_new || !is_same_pane;
    const bool fades = window.shown.faded_in_from.has_value();
    if (!is_new && !fades) return;
    Canvas::Backdrop& backdrop = canvas_->renewBackdrop();
    if (is_new) {
      // A fade begins with what is on the screen, in the middle of another fade too.
      fade_from_.clear();
      if (fades && is_same_pane) fade_from_ = backdrop.bgra;
      scalePixels(picture.rgba, picture.width, picture.height, pane.width, pane.height,
                  fades ? fade_to_ : backdrop.bgra);
    }
    if (fades) {
      // A pane of another size has no picture to fade from.
      const bool has_both = fade_from_.size() == fade_to_.size();
      mixPixels(has_both ? fade_from_ : fade_to_, fade_to_, window.shown.share, backdrop.bgra);
    }
    shown_pane_ = pane;
    backdrop.width = pane.width;
    backdrop.height = pane.height;
  }

  void askForReport(WindowClock::time_point now) {
    WindowState& window = *state_;
    // The counters change with every block that is read; a person cannot follow them faster than
    // this.
    if (!window.isOpen() || now - reported_at_ < std::chrono::duration<double>(kReport_s)) return;
    reported_at_ = now;
    window.desk.wantReport(window.panels.shows_maps);
  }

  void keepSettings() {
    if (request_.settings_file.empty()) return;
    WindowState& window = *state_;
    glfwGetWindowSize(window_, &window.settings.width, &window.settings.height);
    window.desk.saveText(request_.settings_file, settingsText(window.settings), {});
  }

  void logTimes(const DeskTimes& desk) {
    const auto percentile = [](std::vector<double> all, double share) {
      if (all.empty()) return 0.0;
      std::sort(all.begin(), all.end());
      return all[std::min(all.size() - 1,
                          static_cast<size_t>(share * static_cast<double>(all.size())))];
    };
    const LoopTimes& times = state_->loop.times;
    state_->log.write({{"end", true},
                       {"turns", times.turns},
                       {"events", times.events},
                       {"longest_start_turn_seconds", start_s_},
                       {"turn_p95_seconds", percentile(times.turn_s, 0.95)},
                       {"longest_turn_seconds", percentile(times.turn_s, 1)},
                       {"gl_p50_seconds", percentile(times.gl_s, 0.5)},
                       {"gl_p95_seconds", percentile(times.gl_s, 0.95)},
                       {"stalls", times.stalls},
                       {"gl_errors", times.gl_errors},
                       {"answers", times.answer_s.size()},
                       {"answer_p50_seconds", percentile(times.answer_s, 0.5)},
                       {"answer_p95_seconds", percentile(times.answer_s, 0.95)},
                       {"wishes", desk.wishes},
                       {"previews", desk.previews},
                       {"complete", desk.complete},
                       {"cancelled", desk.cancelled}});
  }

  const WindowRequest& request_;
  const Glfw glfw_;
  Events events_;
  uint64_t seen_events_ = 0, echoed_ = 0;
  bool is_put_off_ = false;  // the last frame is not on the screen yet
  int frames_left_ = 3;
  float density_ = 1;
  double start_s_ = 0;  // the longest of the first turns
  GLFWwindow *window_ = nullptr, *drawing_window_ = nullptr;
  bool is_software_ = false;
  std::optional<Canvas> canvas_;
  Pane shown_pane_;  // the canvas has the picture for this pane
  // Pixels of the pane, while a picture fades in: where the fade begins and ends.
  std::vector<uint32_t> fade_from_, fade_to_;
  std::unique_ptr<WindowState> state_;
  WindowClock::time_point reported_at_{}, presented_at_{};
};

}  // namespace
}  // namespace sluice

extern "C" const char* sluiceWindowVersion();
extern "C" const char* sluiceWindowVersion() {
  return sluice::kWindowModuleVersion;
}

extern "C" void sluiceRunWindow(const sluice::WindowRequest& request);
extern "C" void sluiceRunWindow(const sluice::WindowRequest& request) {
  sluice::Window(request).run();
}

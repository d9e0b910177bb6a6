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
#include <optional>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/view/scaled_pixels.h"
#include "src/view/window/canvas.h"
#include "src/view/window/panels.h"
#include "src/view/window/surface.h"
#include "src/view/window_module.h"

namespace sluice {
namespace {

constexpr float kPanelWidth = 330, kSlicesHeight = 240;  // screen units at a font scale of 1
// The first frames make fonts and shaders: they are measured apart.
constexpr uint64_t kStartTurns = 8;
constexpr size_t kMostTimes = size_t{1} << 18;
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
  if (std::filesystem::exists(kFont, unknown)) {
    io.Fonts->AddFontFromFileTTF(kFont, std::round(14 * scale), &config);
  } else {
    config.SizePixels = std::round(13 * scale);
    io.Fonts->AddFontDefault(&config);
  }
}

void section(Sitting& sitting, const char* name, bool is_open, void (*panel)(Sitting&)) {
  ImGui::SetNextItemOpen(is_open, ImGuiCond_Once);
  const bool shown = ImGui::CollapsingHeader(name);
  sitting.log.control(std::string("section ") + name);
  if (!shown) return;
  ImGui::PushID(name);
  panel(sitting);
  ImGui::PopID();
}

void sidePanel(Sitting& sitting, const Area& area) {
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus |
                   ImGuiWindowFlags_AlwaysVerticalScrollbar);  // nothing moves when it comes
  if (sitting.isOpen()) {
    const VolumeInfo& info = sitting.info();
    ImGui::TextDisabled(
        "%s",
        fmt::format("{}: {} x {} x {} {}, {}", info.name, info.dims[0], info.dims[1], info.dims[2],
                    info.type, sitting.opened->device.substr(0, sitting.opened->device.find(',')))
            .c_str());
    section(sitting, "look", true, lookPanel);
    section(sitting, "opacity over values", true, transferPanel);
    if (info.time_steps > 1) section(sitting, "time", true, timePanel);
    section(sitting, "view", true, viewPanel);
    section(sitting, "cut", false, cutPanel);
    section(sitting, "film", false, filmPanel);
    section(sitting, "levels of memory", false, levelsPanel);
  }
  section(sitting, "files", true, filePanel);
  ImGui::End();
}

// Of one turn of the loop, and what parts of it took.
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
        sitting_(std::make_unique<Sitting>(request, [] { glfwPostEmptyEvent(); })) {
    const auto scale = static_cast<float>(request.settings.font_scale);
    window_ = makeWindow(request, kPanelWidth * scale);
    glfwMakeContextCurrent(window_);
    hearDriver(*sitting_);
    is_software_ = drawsInSoftware();
    glfwSwapInterval(is_software_ ? 0 : 1);  // processors have no vertical blank
    canvas_.emplace();
    if (request.lend && (!is_software_ || request.lends_software))
      drawing_window_ = lendContext(request, window_);
    sitting_->keeps_pixels = is_software_;
    watchEvents(window_, events_);
    float density = 1, ignored = 1;
    glfwGetWindowContentScale(window_, &density, &ignored);
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::StyleColorsDark();
    chooseFont(density);
    ImGui::GetStyle().ScaleAllSizes(density);
    density_ = density;
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 330");
    request.tell_news([] { glfwPostEmptyEvent(); });
  }
  ~Window() {
    request_.tell_news(nullptr);
    request_.end_desk();
    if (sitting_->log.isOn()) glDisable(GL_DEBUG_OUTPUT);  // which would say it to the sitting
    sitting_.reset();                                      // its textures, while there is a context
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
    if (!request_.volume.paths.empty()) request_.desk->open(request_.volume, std::nullopt);
    while (glfwWindowShouldClose(window_) == 0 && !sitting_->wants_to_end &&
           !request_.is_asked_to_end())
      turn();
    keepSettings();
    logTimes();
  }

 private:
  // One frame of the window: it waits in its first line and nowhere else.
  void turn() {
    double wait_s = frames_left_ > 0 ? kSettle_s : kIdle_s;
    if (sitting_->wake_at)
      wait_s =
          std::clamp(std::chrono::duration<double>(*sitting_->wake_at - WindowClock::now()).count(),
                     kSettle_s, wait_s);
    glfwWaitEventsTimeout(wait_s);
    TurnTimes times;
    const auto began = WindowClock::now();
    Sitting& sitting = *sitting_;
    if (events_.count != seen_events_) {
      sitting.times.events += events_.count - seen_events_;
      seen_events_ = events_.count;
      sitting.event_at = began;
      // Highlights and menus settle over a few frames.
      frames_left_ = 2;
    }
    sitting.wake_at.reset();
    if (frames_left_ > 0) --frames_left_;
    sitting.takeNews();
    if (!events_.dropped.empty()) sitting.openAny(std::exchange(events_.dropped, {}));
    sitting.play();
    sitting.showPlayedFrame();
    times.news_s = secondsSince(began);
    build();
    times.build_s = secondsSince(began) - times.news_s;
    sitting.sendWish();
    askForReport(began);
    times.wish_s = secondsSince(began) - times.news_s - times.build_s;
    times.gl_s = present();
    times.all_s = secondsSince(began);
    note(times);
  }

  void note(const TurnTimes& times) {
    Sitting& sitting = *sitting_;
    ++sitting.times.turns;
    if (sitting.times.turns <= kStartTurns) {
      start_s_ = std::max(start_s_, times.all_s);
      return;
    }
    if (sitting.times.turn_s.size() < kMostTimes) {
      sitting.times.turn_s.push_back(times.all_s);
      if (times.gl_s > 0) sitting.times.gl_s.push_back(times.gl_s);
    }
    if (times.all_s <= kStall_s) return;
    ++sitting.times.stalls;
    sitting.log.write({{"long_turn_seconds", times.all_s},
                       {"news_seconds", times.news_s},
                       {"build_seconds", times.build_s},
                       {"wish_seconds", times.wish_s},
                       {"gl_seconds", times.gl_s},
                       {"drawn_pixels", canvas_->drawnPixels()}});
  }

  void build() {
    Sitting& sitting = *sitting_;
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGuiIO& io = ImGui::GetIO();
    io.FontGlobalScale = static_cast<float>(sitting.settings.font_scale);
    ImGui::NewFrame();
    sitting.hand_is_on = ImGui::IsAnyMouseDown();
    for (int button = 0; button < 3; ++button)
      if (ImGui::IsMouseClicked(button)) sitting.beginGesture();
    const float panel = std::min(kPanelWidth * density_ * io.FontGlobalScale, io.DisplaySize.x / 2);
    const bool has_slices = sitting.isOpen() && sitting.state().shows_slices;
    const float strip = has_slices ? std::min(kSlicesHeight * density_, io.DisplaySize.y / 2) : 0;
    const Area pane{0, 0, io.DisplaySize.x - panel, io.DisplaySize.y - strip};
    picturePane(sitting, pane, io.DisplayFramebufferScale.x);
    if (has_slices) slicesPane(sitting, {0, pane.height, pane.width, strip});
    sidePanel(sitting, {pane.width, 0, panel, io.DisplaySize.y});
    takeKeys(sitting);
    helpWindow(sitting);
    openWindow(sitting);
    failuresWindow(sitting);
    ImGui::Render();
  }

  // What is another than on the screen, drawn and shown; the seconds that took, 0 where nothing
  // was.
  double present() {
    Sitting& sitting = *sitting_;
    const auto began = WindowClock::now();
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    if (width == 0 || height == 0) return 0;
    if (sitting.picture_is_new) canvas_->noteRedrawn(sitting.texture.id());
    if (is_software_) updateBackdrop();
    for (size_t axis = 0; axis < sitting.slices.size(); ++axis)
      if (sitting.slice_is_new[axis]) canvas_->noteRedrawn(sitting.slices[axis].id());
    ImDrawData& data = *ImGui::GetDrawData();
    const bool is_same = canvas_->compare(data, width, height).empty();
    if (is_same && !sitting.picture_is_new && !events_.wants_refresh) return 0;
    if (is_software_ && !sitting.picture_is_new && sitting.awaitsPicture() &&
        began - presented_at_ < kWithPicture) {
      sitting.wakeBy(presented_at_ + kWithPicture);
      return 0;
    }
    canvas_->draw(data);
    while (glGetError() != GL_NO_ERROR && sitting.times.gl_errors < 1'000'000)
      ++sitting.times.gl_errors;
    glfwSwapBuffers(window_);
    events_.wants_refresh = false;
    presented_at_ = WindowClock::now();
    const double took = std::chrono::duration<double>(presented_at_ - began).count();
    if (is_software_ && sitting.picture_is_new)
      sitting.showing_s += (took - sitting.showing_s) / kShowingMean;
    sitting.notePresented();
    return took;
  }

  // Scaled to the pane by the processor, where it would do so in OpenGL's place.
  void updateBackdrop() {
    Sitting& sitting = *sitting_;
    const ShownPicture& picture = sitting.picture;
    if (!sitting.isOpen() || picture.rgba.empty()) return canvas_->dropBackdrop();
    const Pane& pane = sitting.pane;
    if (!sitting.picture_is_new && pane.width == shown_pane_.width &&
        pane.height == shown_pane_.height)
      return;
    shown_pane_ = pane;
    Canvas::Backdrop& backdrop = canvas_->renewBackdrop();
    scalePixels(picture.rgba, picture.width, picture.height, pane.width, pane.height,
                backdrop.bgra);
    backdrop.width = pane.width;
    backdrop.height = pane.height;
  }

  void askForReport(WindowClock::time_point now) {
    Sitting& sitting = *sitting_;
    if (!sitting.isOpen() || now - reported_at_ < std::chrono::duration<double>(kReport_s)) return;
    reported_at_ = now;
    sitting.desk.wantReport(sitting.shows_maps);
  }

  void keepSettings() {
    if (request_.settings_file.empty()) return;
    Sitting& sitting = *sitting_;
    glfwGetWindowSize(window_, &sitting.settings.width, &sitting.settings.height);
    sitting.desk.saveText(request_.settings_file, settingsText(sitting.settings));
  }

  void logTimes() {
    Sitting& sitting = *sitting_;
    const auto percentile = [](std::vector<double> times, double share) {
      if (times.empty()) return 0.0;
      std::sort(times.begin(), times.end());
      return times[std::min(times.size() - 1,
                            static_cast<size_t>(share * static_cast<double>(times.size())))];
    };
    const DeskTimes desk = sitting.desk.times();
    sitting.log.write({{"end", true},
                       {"turns", sitting.times.turns},
                       {"events", sitting.times.events},
                       {"longest_start_turn_seconds", start_s_},
                       {"turn_p95_seconds", percentile(sitting.times.turn_s, 0.95)},
                       {"longest_turn_seconds", percentile(sitting.times.turn_s, 1)},
                       {"gl_p50_seconds", percentile(sitting.times.gl_s, 0.5)},
                       {"gl_p95_seconds", percentile(sitting.times.gl_s, 0.95)},
                       {"stalls", sitting.times.stalls},
                       {"gl_errors", sitting.times.gl_errors},
                       {"answers", sitting.times.answer_s.size()},
                       {"answer_p50_seconds", percentile(sitting.times.answer_s, 0.5)},
                       {"answer_p95_seconds", percentile(sitting.times.answer_s, 0.95)},
                       {"wishes", desk.wishes},
                       {"previews", desk.previews},
                       {"complete", desk.complete},
                       {"cancelled", desk.cancelled}});
  }

  const WindowRequest& request_;
  const Glfw glfw_;
  Events events_;
  uint64_t seen_events_ = 0;
  int frames_left_ = 3;
  float density_ = 1;
  double start_s_ = 0;  // the longest of the first turns
  GLFWwindow *window_ = nullptr, *drawing_window_ = nullptr;
  bool is_software_ = false;
  std::optional<Canvas> canvas_;
  Pane shown_pane_;  // that the canvas has the picture for
  std::unique_ptr<Sitting> sitting_;
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

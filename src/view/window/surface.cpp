#include "src/view/window/surface.h"

#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/error.h"
#include "src/view/window/window_state.h"

namespace sluice {
namespace {

constexpr uint64_t kMostSaid = 20;  // errors of OpenGL in the log

[[noreturn]] void failOf(const std::string& what) {
  // GLFW keeps the last error of each thread; without one the driver has said nothing.
  const char* said = nullptr;
  glfwGetError(&said);
  failSystem("{}{}; `sluice render` draws without a window", what,
             said != nullptr ? fmt::format(": {}", said) : "");
}

// GLFW calls back plain functions, so that the receiver of the events travels as the user pointer
// of the window.
Events& eventsOf(GLFWwindow* window) {
  return *static_cast<Events*>(glfwGetWindowUserPointer(window));
}

using Kind = InputEvent::Kind;

void add(GLFWwindow* window, const InputEvent& event) {
  Events& events = eventsOf(window);
  ++events.count;
  events.input.add(event);
}

}  // namespace

Glfw::Glfw() {
  if (glfwInit() != GLFW_TRUE) failOf("no display");
}

Glfw::~Glfw() {
  glfwTerminate();
}

GLFWwindow* makeWindow(const WindowRequest& request, float panel_width) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  // A debug context makes the driver check each call, which takes time, so only those who keep a
  // log get it (hearDriver()).
  glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, request.log_file.empty() ? GLFW_FALSE : GLFW_TRUE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  int width = request.settings.width, height = request.settings.height;
  // --size means the pane, so that the window is wider by its panel.
  if (request.pane_width > 0) {
    width = request.pane_width + static_cast<int>(panel_width);
    height = request.pane_height;
  }
  GLFWwindow* window = glfwCreateWindow(width, height, "sluice", nullptr, nullptr);
  if (window == nullptr) failOf("no window with OpenGL 3.3");
  return window;
}

void watchEvents(GLFWwindow* window, Events& events) {
  glfwSetWindowUserPointer(window, &events);
  double x = 0, y = 0;
  glfwGetCursorPos(window, &x, &y);
  // The first movement is counted from the place where the pointer is now. Whole numbers are kept,
  // as ImGui does, so that the steps of a drag add up to what ImGui sees.
  events.x = std::floor(x);
  events.y = std::floor(y);
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double to_x, double to_y) {
    add(w, {.kind = Kind::kMove, .x = to_x, .y = to_y});
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int) {
    add(w, {.kind = Kind::kButton, .code = button, .is_on = action != GLFW_RELEASE});
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double by_x, double by_y) {
    add(w, {.kind = Kind::kWheel, .x = by_x, .y = by_y});
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
    add(w, {.kind = Kind::kKey, .code = key, .is_on = action != GLFW_RELEASE});
  });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned character) {
    add(w, {.kind = Kind::kText, .code = static_cast<int>(character)});
  });
  glfwSetCursorEnterCallback(window, [](GLFWwindow* w, int entered) {
    add(w, {.kind = Kind::kEnter, .is_on = entered != 0});
  });
  glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int focused) {
    add(w, {.kind = Kind::kFocus, .is_on = focused != 0});
  });
  // A new size needs no entry in the queue: the next turn asks for it. The count alone ends the
  // wait.
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { ++eventsOf(w).count; });
  // Parts of the window were uncovered. Nothing of ours has changed, so that only this flag makes
  // present() copy the canvas again.
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) {
    ++eventsOf(w).count;
    eventsOf(w).wants_refresh = true;
  });
  // GLFW owns the names for the time of the call alone, so they are copied.
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    ++eventsOf(w).count;
    eventsOf(w).dropped.assign(paths, paths + count);
  });
}

void takeInput(GLFWwindow* window, Events& events, WindowState& state) {
  state.pointer.steps.clear();
  // The queue gives as many events as one frame of ImGui can tell apart: a press and a release in
  // one frame would be no click.
  for (const InputEvent& event : events.input.take()) {
    const int is_on = event.is_on ? GLFW_TRUE : GLFW_FALSE;
    switch (event.kind) {
      case Kind::kMove: {
        const double x = std::floor(event.x), y = std::floor(event.y);
        state.pointer.steps.push_back({x - events.x, y - events.y});
        events.x = x;
        events.y = y;
        break;
      }
      case Kind::kButton:
        // Buttons are kept here and handed over below. The backend samples the state of now
        // instead, in which a short click is over already.
        if (event.code >= 0 && static_cast<size_t>(event.code) < events.is_down.size())
          events.is_down[static_cast<size_t>(event.code)] = event.is_on;
        break;
      case Kind::kWheel:
        ImGui_ImplGlfw_ScrollCallback(window, event.x, event.y);
        break;
      case Kind::kKey:
        ImGui_ImplGlfw_KeyCallback(window, event.code, 0, is_on ? GLFW_PRESS : GLFW_RELEASE, 0);
        // Tests press this key to learn that all events before it have been drawn.
        if (event.code == kEchoKey && !event.is_on) ++events.echoes;
        break;
      case Kind::kText:
        ImGui_ImplGlfw_CharCallback(window, static_cast<unsigned>(event.code));
        break;
      case Kind::kEnter:
        ImGui_ImplGlfw_CursorEnterCallback(window, is_on);
        break;
      case Kind::kFocus:
        ImGui_ImplGlfw_WindowFocusCallback(window, is_on);
        break;
    }
  }
  ImGui_ImplGlfw_NewFrame();
  ImGuiIO& io = ImGui::GetIO();
  // NewFrame() has read the pointer's position of now, and the events that were taken end earlier.
  if (ImGui::IsMousePosValid(&io.MousePos))
    io.MousePos = {static_cast<float>(events.x), static_cast<float>(events.y)};
  std::copy(events.is_down.begin(), events.is_down.end(), std::begin(io.MouseDown));
}

GLFWwindow* lendContext(const WindowRequest& request, GLFWwindow* window) {
  // A hidden window is GLFW's only way to a second context that shares its objects.
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  GLFWwindow* const lent = glfwCreateWindow(1, 1, "sluice", nullptr, window);
  glfwWindowHint(GLFW_VISIBLE, GLFW_TRUE);
  // A driver may refuse a second context. The desk then sends pixels, as it does in software.
  if (lent == nullptr) return nullptr;
  ScreenContext screen;
  // GLFW allows these two calls from any thread, as long as the context is current on one at a
  // time. The renderer calls them on its own thread.
  screen.make_current = [lent] { glfwMakeContextCurrent(lent); };
  screen.release = [] { glfwMakeContextCurrent(nullptr); };
  screen.find = [](const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); };
  request.lend(std::make_shared<const ScreenContext>(std::move(screen)));
  return lent;
}

void hearDriver(WindowState& window) {
  if (!window.log.isOn()) return;
  const auto listen =
      reinterpret_cast<PFNGLDEBUGMESSAGECALLBACKPROC>(glfwGetProcAddress("glDebugMessageCallback"));
  if (listen == nullptr || glfwExtensionSupported("GL_KHR_debug") == GLFW_FALSE) return;
  glEnable(GL_DEBUG_OUTPUT);
  // Messages come on this thread, within the call that they are about.
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  const auto hear = [](GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* words,
                       const void* to) {
    // Hints about performance are no errors.
    if (type != GL_DEBUG_TYPE_ERROR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) return;
    // The state outlives the callback: the window switches debug output off before it lets go of
    // the state.
    WindowState& heard_by = *static_cast<WindowState*>(const_cast<void*>(to));
    if (++heard_by.loop.times.gl_errors <= kMostSaid) heard_by.log.write({{"gl_message", words}});
  };
  listen(hear, &window);
}

bool drawsInSoftware() {
  // There is no question for this in OpenGL. Mesa names its two software drivers here.
  const GLubyte* const renderer = glGetString(GL_RENDERER);
  const std::string name = renderer == nullptr ? "" : reinterpret_cast<const char*>(renderer);
  return name.find("llvmpipe") != std::string::npos || name.find("softpipe") != std::string::npos;
}

}  // namespace sluice

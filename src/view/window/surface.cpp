#include "src/view/window/surface.h"

#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/error.h"
#include "src/view/window/window_state.h"

namespace sluice {
namespace {

constexpr uint64_t kMostSaid = 20;  // errors of OpenGL in the log

[[noreturn]] void failOf(const std::string& what) {
  const char* said = nullptr;
  glfwGetError(&said);
  failSystem("{}{}; `sluice render` draws without a window", what,
             said != nullptr ? fmt::format(": {}", said) : "");
}

Events& eventsOf(GLFWwindow* window) {
  return *static_cast<Events*>(glfwGetWindowUserPointer(window));
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
  glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, request.log_file.empty() ? GLFW_FALSE : GLFW_TRUE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  int width = request.settings.width, height = request.settings.height;
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
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double, double) { ++eventsOf(w).count; });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int, int, int) { ++eventsOf(w).count; });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double) { ++eventsOf(w).count; });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int, int, int, int) { ++eventsOf(w).count; });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned) { ++eventsOf(w).count; });
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { ++eventsOf(w).count; });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) {
    ++eventsOf(w).count;
    eventsOf(w).wants_refresh = true;
  });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    ++eventsOf(w).count;
    eventsOf(w).dropped.assign(paths, paths + count);
  });
}

GLFWwindow* lendContext(const WindowRequest& request, GLFWwindow* window) {
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  GLFWwindow* const lent = glfwCreateWindow(1, 1, "sluice", nullptr, window);
  glfwWindowHint(GLFW_VISIBLE, GLFW_TRUE);
  if (lent == nullptr) return nullptr;
  ScreenContext screen;
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
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  const auto hear = [](GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* words,
                       const void* to) {
    if (type != GL_DEBUG_TYPE_ERROR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) return;
    WindowState& heard_by = *static_cast<WindowState*>(const_cast<void*>(to));
    if (++heard_by.loop.times.gl_errors <= kMostSaid) heard_by.log.write({{"gl_message", words}});
  };
  listen(hear, &window);
}

bool drawsInSoftware() {
  const GLubyte* const renderer = glGetString(GL_RENDERER);
  const std::string name = renderer == nullptr ? "" : reinterpret_cast<const char*>(renderer);
  return name.find("llvmpipe") != std::string::npos || name.find("softpipe") != std::string::npos;
}

}  // namespace sluice

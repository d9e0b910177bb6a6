// Surface: what GLFW gives a window to draw on, and what it tells of events. The window's thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/view/drawing/window_module.h"

struct GLFWwindow;

namespace sluice {

struct WindowState;

// GLFW, from its beginning to its end. Throws Error where there is no display.
class Glfw {
 public:
  Glfw();
  ~Glfw();
  Glfw(const Glfw&) = delete;
  Glfw& operator=(const Glfw&) = delete;
};

// What GLFW's callbacks reach.
struct Events {
  uint64_t count = 0;
  bool wants_refresh = false;  // what the window shows was lost
  std::vector<std::string> dropped;
};

// Of the size that is asked for, with room for a panel (screen units) beside a picture of that
// size; its context is current on no thread yet. Throws Error: no OpenGL 3.3.
GLFWwindow* makeWindow(const WindowRequest& request, float panel_width);
// From now on `events` has what comes; it must outlive the window.
void watchEvents(GLFWwindow* window, Events& events);
// Gives request.lend a context that shares textures with the window's: that of a window which is
// never shown, to be destroyed when the desk has ended. Null where there is none; pictures then
// come as pixels.
GLFWwindow* lendContext(const WindowRequest& request, GLFWwindow* window);
// Counts what the driver of the current context says of errors, and says it in the log, where there
// is one. The state must outlive that.
void hearDriver(WindowState& window);
// Whether the current context's driver draws on the processor.
bool drawsInSoftware();

}  // namespace sluice

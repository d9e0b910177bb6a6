// Surface: the window's GLFW surface and its events. The window's thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/view/drawing/window_module.h"

struct GLFWwindow;

namespace sluice {

struct WindowState;

// GLFW, from its beginning to its end. Throws Error if there is no display.
class Glfw {
 public:
  Glfw();
  ~Glfw();
  Glfw(const Glfw&) = delete;
  Glfw& operator=(const Glfw&) = delete;
};

// The state that GLFW's callbacks write.
struct Events {
  uint64_t count = 0;
  bool wants_refresh = false;  // the window's content was lost
  std::vector<std::string> dropped;
};

// Makes a window of the requested size, with room for a panel (screen units) next to a picture of
// that size; its context is current on no thread yet. Throws Error: no OpenGL 3.3.
GLFWwindow* makeWindow(const WindowRequest& request, float panel_width);
// From now on `events` receives the events; it must outlive the window.
void watchEvents(GLFWwindow* window, Events& events);
// Gives request.lend a context that shares textures with the window's: the context of a window that
// is never shown, to be destroyed when the desk has ended. Null if there is none; pictures then
// come as pixels.
GLFWwindow* lendContext(const WindowRequest& request, GLFWwindow* window);
// Counts the errors that the current context's driver reports, and logs them if there is a log. The
// state must outlive that.
void hearDriver(WindowState& window);
// Whether the current context's driver draws on the processor.
bool drawsInSoftware();

}  // namespace sluice

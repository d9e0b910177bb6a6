// Surface: the window's GLFW surface and its events. The window's thread.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "src/view/drawing/window_module.h"
#include "src/view/state/screen/input_queue.h"

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
  InputQueue input;
  // The pointer and its buttons after the events that frames have taken. GLFW itself knows only
  // those after the last event that came.
  double x = 0, y = 0;  // whole screen units
  std::array<bool, 5> is_down{};
  uint64_t echoes = 0;  // times that kEchoKey was let go
};

// Does nothing to the view: programs that send events press it to know from the log when the events
// before it are on the screen.
constexpr int kEchoKey = 301;  // F12

// Makes a window of the requested size, with room for a panel (screen units) next to a picture of
// that size; its context is current on no thread yet. Throws Error: no OpenGL 3.3.
GLFWwindow* makeWindow(const WindowRequest& request, float panel_width);
// From now on `events` receives the events; it must outlive the window.
void watchEvents(GLFWwindow* window, Events& events);
// Begins a frame of Dear ImGui's with the events that come next, in place of the state that GLFW
// has reached; the pointer's steps are those of this frame.
void takeInput(GLFWwindow* window, Events& events, WindowState& state);
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

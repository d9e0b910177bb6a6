// The interface between the program and its window.
//
// The window needs a display's libraries, which a node without a screen has not: so all of it is a
// module apart, sluice_window.so (src/view/window), opened when `sluice view` is asked for and by
// nothing else. It knows the Desk and plain data; the volume, the renderer and their threads stay
// in the program. Both belong to one build; an exception from the module is an Error there and
// here.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "src/view/drawing/desk.h"
#include "src/view/state/files/settings.h"

namespace sluice {

struct WindowRequest {
  Desk* desk = nullptr;
  ViewedVolume volume;  // no paths: the window asks for one
  std::vector<std::string> color_maps;
  std::vector<std::string> volume_endings;  // endings of names, see FolderQuestion
  int pane_width = 0, pane_height = 0;      // pixels of the picture; 0: as the settings have it
  Settings settings;
  std::string settings_file;  // empty: they are not kept
  std::string log_file;       // events, a JSON object a line; empty: none
  // Sets the function that is told of the desk's news, from any thread; an empty function: nobody.
  std::function<void(std::function<void()>)> tell_news;
  // Takes a context that shares textures with the window's, before anything is opened; empty: the
  // picture's pixels are wanted. Software contexts are lent only if `lends_software`.
  std::function<void(std::shared_ptr<const ScreenContext>)> lend;
  bool lends_software = false;
  // The desk has ended when this returns: contexts that were lent may go. Returns lines for people,
  // such as the files that it could not write any more. Further calls do nothing.
  std::function<std::vector<std::string>()> end_desk;
  // Called now and then: whether the window is to close.
  std::function<bool()> is_asked_to_end;
  // Lines for people, on standard output.
  std::function<void(const std::string&)> say;
};

// The one function of the module. Returns when the window is closed. Throws Error: no display, no
// OpenGL 3.3.
using RunWindow = void(const WindowRequest& request);
inline constexpr const char* kRunWindow = "sluiceRunWindow";

// See io/vdb/vdb_module.h. The number counts up with each change of this interface.
inline constexpr const char* kWindowVersion = "sluiceWindowVersion";
inline constexpr const char* kWindowModuleVersion = SLUICE_VERSION " window 3";

// Opens the module from the folder where the program was built or installed, and nowhere else.
// Throws Error if it is not there, or of another version.
RunWindow* openWindowModule();

}  // namespace sluice

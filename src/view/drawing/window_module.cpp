#include "src/view/drawing/window_module.h"

#include <span>
#include <string_view>

#include "src/base/error.h"
#include "src/base/files/module_path.h"
#include "src/base/files/shared_library.h"

namespace sluice {

RunWindow* openWindowModule() {
  const std::string name = modulePath("sluice_window.so");
  try {
    const SharedLibrary library(
        std::span(&name, 1),
        "sluice's window; build with libglfw3-dev and libimgui-dev, and install libglfw3");
    const std::string_view version = library.get<WindowVersion*>(kWindowVersion)();
    if (version != kWindowModuleVersion)
      fail("{} belongs to sluice {}, expected {}; install sluice again", name, version,
           kWindowModuleVersion);
    return library.get<RunWindow*>(kRunWindow);
  } catch (const Error& error) {
    fail("no window here, sluice render draws without one: {}", error.what());
  }
}

}  // namespace sluice

#include "src/view/drawing/window_module.h"

#include "src/base/error.h"
#include "src/base/files/program_module.h"

namespace sluice {

RunWindow* openWindowModule() {
  try {
    return openModule({"sluice_window.so",
                       "sluice's window; install the package sluice-window and libglfw3, or build "
                       "with libglfw3-dev and libimgui-dev",
                       kWindowVersion, kWindowModuleVersion})
        .get<RunWindow*>(kRunWindow);
  } catch (const Error& error) {
    failAs(error.kind(), "no window here, sluice render draws without one: {}", error.what());
  }
}

}  // namespace sluice

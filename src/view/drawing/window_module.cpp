#include "src/view/drawing/window_module.h"

#include <filesystem>
#include <span>
#include <string_view>
#include <system_error>

#include "src/base/error.h"
#include "src/base/shared_library.h"

namespace sluice {

RunWindow* openWindowModule() {
  std::error_code unknown;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const bool in_build_folder = !unknown && program.parent_path() == SLUICE_BUILD_FOLDER;
  const std::string name = in_build_folder ? SLUICE_BUILD_FOLDER "/" SLUICE_WINDOW_MODULE
                                           : SLUICE_INSTALL_FOLDER "/" SLUICE_WINDOW_MODULE;
  try {
    const SharedLibrary library(
        std::span(&name, 1),
        "sluice's window; build with libglfw3-dev and libimgui-dev, and install libglfw3");
    const std::string_view version = library.get<WindowVersion*>(kWindowVersion)();
    if (version != kWindowModuleVersion)
      fail("{} is of sluice {}, expected {}; install sluice again", name, version,
           kWindowModuleVersion);
    return library.get<RunWindow*>(kRunWindow);
  } catch (const Error& error) {
    fail("no window here, sluice render draws without one: {}", error.what());
  }
}

}  // namespace sluice

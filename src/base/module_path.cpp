#include "src/base/module_path.h"

#include <filesystem>
#include <system_error>

// Where the installed library's modules are, in programs that its package has built: it may have
// been installed anywhere. Null in our own.
extern "C" [[gnu::weak]] const char* sluiceModuleFolder();

namespace sluice {

std::string modulePath(std::string_view file) {
  const std::string name = "/" + std::string(file);
  if (sluiceModuleFolder != nullptr) return sluiceModuleFolder() + name;
  std::error_code unknown;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const bool in_build_folder = !unknown && program.parent_path() == SLUICE_BUILD_FOLDER;
  return (in_build_folder ? SLUICE_BUILD_FOLDER : SLUICE_INSTALL_FOLDER) + name;
}

}  // namespace sluice

// The folder of the modules that readers open at run time (OpenVDB, the web): see
// src/base/files/module_path.cpp. An installed package, PREFIX/lib/python3/dist-packages/sluice,
// has them in PREFIX/lib/sluice; a build has them at its top, above python/sluice.
#include <dlfcn.h>

#include <filesystem>
#include <string>
#include <system_error>

extern "C" const char* sluiceModuleFolder();

extern "C" const char* sluiceModuleFolder() {
  static const std::string folder = [] {
    Dl_info self{};
    if (dladdr(reinterpret_cast<const void*>(&sluiceModuleFolder), &self) == 0)
      return std::string();
    std::error_code none;
    const auto package = std::filesystem::canonical(self.dli_fname, none).parent_path();
    const auto build = package.parent_path().parent_path();
    const bool is_build = std::filesystem::exists(build / "CMakeCache.txt", none);
    return (is_build ? build : build.parent_path() / "sluice").string();
  }();
  return folder.c_str();
}

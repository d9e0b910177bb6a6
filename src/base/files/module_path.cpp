#include "src/base/files/module_path.h"

#include <sys/stat.h>

#include <filesystem>
#include <system_error>

// The folder of the installed library's modules. Programs built with its package define it, because
// the package may be installed anywhere. Null in our own programs.
extern "C" [[gnu::weak]] const char* sluiceModuleFolder();

namespace sluice {

namespace {

// Whether `path` belongs to `owner`, and nobody else can write to it.
bool isOwnedAlone(const std::filesystem::path& path, uid_t owner) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 && status.st_uid == owner &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

// Whether the module may be opened from its folder: anyone who could replace it could replace the
// program.
bool isTrusted(const std::filesystem::path& program, const std::filesystem::path& module) {
  struct stat status {};
  return stat(program.c_str(), &status) == 0 && isOwnedAlone(program, status.st_uid) &&
         isOwnedAlone(program.parent_path(), status.st_uid) && isOwnedAlone(module, status.st_uid);
}

}  // namespace

std::string modulePath(std::string_view file) {
  std::string name = "/";
  name += file;
  if (sluiceModuleFolder != nullptr) return sluiceModuleFolder() + name;
  std::error_code unknown;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  if (!unknown && program.parent_path() == SLUICE_BUILD_FOLDER) return SLUICE_BUILD_FOLDER + name;
  const std::filesystem::path beside = program.parent_path() / file;
  if (!unknown && isTrusted(program, beside)) return beside.string();
  return SLUICE_INSTALL_FOLDER + name;
}

}  // namespace sluice

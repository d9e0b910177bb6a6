#include "src/base/files/program_module.h"

#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "src/base/error.h"

// The folders of the modules, with ':' between. Relative ones begin at the folder of the file that
// this code runs from. Python's extension module defines it, and programs that are built with the
// installed package do, whose modules lie apart from them. Null in our own programs.
extern "C" [[gnu::weak]] const char* sluiceModuleFolders();

namespace sluice {
namespace {

namespace fs = std::filesystem;

std::string moduleFolders() {
  if (sluiceModuleFolders != nullptr) return sluiceModuleFolders();
  return ".:" SLUICE_MODULES_FROM_PROGRAM ":" SLUICE_INSTALLED_MODULES;
}

// The file of the program or library that holds this function; empty if it is not known.
fs::path ownFile() {
  std::error_code unknown;
  Dl_info info{};
  link_map* object = nullptr;
  const auto* const here = reinterpret_cast<const void*>(&moduleFolders);
  // A program's own name is empty here: dladdr() would give argv[0], which anybody may choose.
  if (dladdr1(here, &info, reinterpret_cast<void**>(&object), RTLD_DL_LINKMAP) != 0 &&
      object != nullptr && object->l_name != nullptr && object->l_name[0] != '\0')
    return fs::canonical(object->l_name, unknown);
  return fs::read_symlink("/proc/self/exe", unknown);
}

// Those who could replace the file of the program: its owner, root, and the members of groups that
// may write to it or to its folder. Whoever can write a module gets no more than that.
class Replacers {
 public:
  explicit Replacers(const fs::path& file) {
    for (const fs::path& path : {file, file.parent_path()}) {
      struct stat status {};
      // Anybody may replace the program, or nobody knows who: then no module is trusted.
      if (stat(path.c_str(), &status) != 0 || (status.st_mode & S_IWOTH) != 0) return;
      if ((status.st_mode & S_IWGRP) != 0) groups_.push_back(status.st_gid);
      if (path == file) owner_ = status.st_uid;
    }
    is_known_ = true;
  }
  // Whether nobody else can write to `path`.
  bool own(const fs::path& path) const {
    struct stat status {};
    if (!is_known_ || stat(path.c_str(), &status) != 0) return false;
    if (status.st_uid != owner_ && status.st_uid != 0) return false;
    if ((status.st_mode & S_IWOTH) != 0) return false;
    return (status.st_mode & S_IWGRP) == 0 ||
           std::ranges::find(groups_, status.st_gid) != groups_.end();
  }

 private:
  bool is_known_ = false;
  uid_t owner_ = 0;
  std::vector<gid_t> groups_;
};

// Whether the module, and each folder that leads to it from a folder above the program, belongs to
// those who could replace the program.
bool isTrusted(const fs::path& program, const fs::path& module) {
  const Replacers replacers(program);
  const std::string program_folder = program.parent_path().string() + "/";
  for (fs::path at = module; !program_folder.starts_with((at / "").string()); at = at.parent_path())
    if (!replacers.own(at)) return false;
  return replacers.own(program.parent_path());
}

// The module's path. Folders that were fixed when the program was built are taken as they are.
std::string modulePath(const std::string& file) {
  const fs::path program = ownFile();
  fs::path path;
  std::optional<fs::path> refused;
  std::istringstream folders(moduleFolders());
  for (std::string part; std::getline(folders, part, ':');) {
    const fs::path folder(part);
    if (folder.is_relative() && program.empty()) continue;
    path = (program.parent_path() / folder / file).lexically_normal();
    std::error_code unknown;
    if (!fs::exists(path, unknown)) continue;
    // A relative folder moves with the program, for instance to a folder that others can write to.
    if (folder.is_absolute() || isTrusted(program, path)) return path.string();
    if (!refused) refused = path;
  }
  if (path.empty()) failSystem("{}: this system does not tell where the program lies", file);
  if (refused)
    failSystem(
        "{}: users who cannot replace {} could have put it there; let its owner alone write to "
        "both and to their folders",
        refused->string(), program.string());
  return path.string();
}

}  // namespace

SharedLibrary openModule(const ProgramModule& module) {
  const std::string path = modulePath(module.file);
  SharedLibrary library(std::span(&path, 1), module.hint);
  const std::string_view version = library.get<const char* (*)()>(module.version_function)();
  // Both share C++ classes, whose layout changes from version to version.
  if (version != module.version)
    failSystem("{} belongs to sluice {}, expected {}; install sluice again", path, version,
               module.version);
  return library;
}

}  // namespace sluice

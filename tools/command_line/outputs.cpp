#include "tools/command_line/outputs.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <optional>

#include "cache/trace/trace.h"
#include "io/files/file_list.h"
#include "io/stores/folder_store.h"
#include "io/zarr/n5/n5_volume.h"
#include "src/base/error.h"
#include "src/base/files/numbered_name.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// The target of a name: an inode or, if there is none yet, a name in the inode of a folder.
struct Target {
  dev_t device = 0;
  ino_t inode = 0;
  std::string name;  // empty: the inode itself
  friend auto operator<=>(const Target&, const Target&) = default;
};

std::optional<struct stat> statusOf(const fs::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return std::nullopt;
  return status;
}

// Pipes and devices (/dev/null) can be written twice and hold nothing.
bool isDevice(const std::optional<struct stat>& status) {
  return status && !S_ISREG(status->st_mode) && !S_ISDIR(status->st_mode);
}

fs::path parentOf(const fs::path& path) {
  const fs::path parent = path.parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

fs::path withoutSlash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

// The path where writing to `path` ends up, when a link there leads to a file that does not exist
// yet.
fs::path followed(fs::path path) {
  // Linux follows 40 links, too, before it gives up (path_resolution(7)).
  constexpr int kMostLinks = 40;
  std::error_code status;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, status); ++i) {
    const fs::path target = fs::read_symlink(path, status);
    if (status) break;
    path = parentOf(path) / target;
  }
  return path;
}

// nullopt: nowhere, since its folder does not exist.
std::optional<Target> targetOf(const fs::path& given) {
  if (const auto status = statusOf(given)) return Target{status->st_dev, status->st_ino, ""};
  const fs::path path = followed(withoutSlash(given));
  const auto folder = statusOf(parentOf(path));
  if (!folder) return std::nullopt;
  return Target{folder->st_dev, folder->st_ino, path.filename().string()};
}

// Throws Error if no file can get this name, because it is too long or its folder is missing or
// closed. Files are written beside their names first, so that their folder counts even if they
// exist; devices such as /dev/null are not.
void requirePlace(const std::string& what, const fs::path& given) {
  struct stat status {};
  const auto refuse = [&](int reason) { failErrno(what + " cannot be written", reason); };
  if (stat(given.c_str(), &status) == 0) {
    if (isDevice(status)) return;
  } else if (errno != ENOENT) {
    refuse(errno);
  }
  const fs::path path = followed(given);
  if (access(parentOf(path).c_str(), W_OK | X_OK) != 0) refuse(errno);
}

bool sameInode(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

// Whether `path` lies in `folder`, at any depth.
bool liesIn(const fs::path& path, const struct stat& folder) {
  std::error_code status;
  // The file need not exist yet.
  fs::path at = fs::weakly_canonical(followed(withoutSlash(path)), status);
  if (status) return false;
  while (at.has_relative_path()) {
    at = at.parent_path();
    const auto here = statusOf(at);
    // Inodes are compared: bind mounts and links give one folder several names.
    if (here && sameInode(*here, folder)) return true;
  }
  return false;
}

// A picture put into a folder of slices is one more slice the next time.
bool isSlice(const fs::path& path) {
  const std::string extension = lowerExtension(path);
  return extension == ".png" || extension == ".tif" || extension == ".tiff";
}

}  // namespace

void Outputs::reads(const fs::path& path) {
  if (!path.empty()) inputs_.push_back(path);
}

void Outputs::reads(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) reads(fs::path(path));
}

void Outputs::writes(const std::string& option, const fs::path& path, FileKind kind) {
  if (!path.empty()) outputs_.push_back({option, path, kind});
}

void Outputs::writesTrace(const std::string& option, const fs::path& path) {
  for (const fs::path& file : traceFiles(path, traceFormatOf(path)))
    if (!path.empty()) writes(option, file, FileKind::kTrace);
}

void Outputs::writesFolder(const std::string& option, const fs::path& path) {
  outputs_.push_back({option, path, FileKind::kRaw, true});
}

namespace {

// The inodes of files that are read: looked up once, however many files are written.
class Inputs {
 public:
  void add(const fs::path& path) {
    const auto status = statusOf(path);
    if (!status) return;
    names_.emplace(Target{status->st_dev, status->st_ino, ""}, path);
    if (!S_ISDIR(status->st_mode)) return;
    const StorePlace place = folderPlace(path);
    // A group of N5 may have attributes in its levels alone.
    folders_.push_back({*status, path, isStore(place) || isN5(place)});
  }

  // Throws Error when writing `path`, which `what` names, would change a file that is read.
  void require(const std::string& what, const fs::path& path, bool is_folder) const {
    const auto status = statusOf(path);
    const auto refuse = [&](const fs::path& input, const char* how) {
      fail("{} {} {}, which this command reads; write to another place", what, how, input.string());
    };
    if (status) {
      const auto found = names_.find(Target{status->st_dev, status->st_ino, ""});
      if (found != names_.end()) refuse(found->second, "is the file");
    }
    if (is_folder && status)
      for (const auto& [target, input] : names_)
        if (liesIn(input, *status)) refuse(input, "holds");
    for (const Folder& folder : folders_)
      if ((folder.is_store || is_folder || isSlice(path)) && liesIn(path, folder.status))
        refuse(folder.path, "lies in");
  }

 private:
  struct Folder {
    struct stat status;
    fs::path path;
    bool is_store;
  };
  std::map<Target, fs::path> names_;
  std::vector<Folder> folders_;
};

}  // namespace

void Outputs::check(const std::vector<std::string>& more_read) const {
  checkNames(more_read);
  for (const Output& output : outputs_)
    if (!output.is_folder) checkExisting(output);
}

void Outputs::checkNames(const std::vector<std::string>& more_read) const {
  if (outputs_.empty()) return;
  Inputs inputs;
  for (const fs::path& path : inputs_) inputs.add(path);
  for (const std::string& path : more_read) inputs.add(path);
  std::map<Target, const Output*> seen;
  for (const Output& output : outputs_) {
    if (isDevice(statusOf(output.path))) continue;
    const std::string what = output.option + " " + output.path.string() + ":";
    if (output.path == "-")
      fail("{} expected the name of a file; only --csv - prints; give ./- for a file of this name",
           what);
    if (const auto target = targetOf(output.path)) {
      const auto [other, is_new] = seen.emplace(*target, &output);
      if (!is_new)
        fail("{} is the same file as {} {}; give two names", what, other->second->option,
             other->second->path.string());
    }
    inputs.require(what, output.path, output.is_folder);
    if (!output.is_folder) requirePlace(what, output.path);
  }
}

void Outputs::checkExisting(const Output& output) const {
  const auto status = statusOf(output.path);
  if (!status || force_ == true) return;
  if (S_ISDIR(status->st_mode))
    fail("{} {}: is a folder; give the name of a file", output.option, output.path.string());
  if (!mayReplace(output.path, output.kind))
    fail("{} {}: exists and is not {}; {}", output.option, output.path.string(),
         nameOf(output.kind), force_ ? "--force replaces it" : "give another name");
}

}  // namespace sluice

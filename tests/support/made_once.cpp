#include "tests/support/made_once.h"

#include <fcntl.h>
#include <sys/file.h>

#include "src/base/error.h"
#include "src/base/files/descriptor.h"

namespace sluice {

namespace fs = std::filesystem;

fs::path madeOnce(const std::string& name, const std::function<bool(const fs::path&)>& make) {
  const fs::path root = fs::read_symlink("/proc/self/exe").parent_path() / "made";
  fs::create_directories(root);
  const Descriptor lock(
      open((root / (name + ".lock")).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (!lock || flock(lock.get(), LOCK_EX) != 0) failErrno(root.string(), errno);
  const fs::path folder = root / name, unfinished = root / (name + ".unfinished");
  if (fs::exists(folder)) return folder;
  fs::remove_all(unfinished);
  fs::create_directory(unfinished);
  if (!make(unfinished)) {
    fs::remove_all(unfinished);
    return {};
  }
  fs::rename(unfinished, folder);
  return folder;
}

}  // namespace sluice

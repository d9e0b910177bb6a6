#include "io/vdb_source.h"

#include <span>
#include <vector>

#include "io/file_list.h"
#include "io/vdb_module.h"
#include "src/base/error.h"
#include "src/base/shared_library.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// Beside the program or where an installed one has it.
fs::path modulePath() {
  std::error_code unknown;
  const fs::path folder = fs::read_symlink("/proc/self/exe", unknown).parent_path();
  const fs::path installed = folder.parent_path() / "lib" / "sluice" / SLUICE_OPENVDB_MODULE;
  return fs::exists(installed, unknown) ? installed : folder / SLUICE_OPENVDB_MODULE;
}

OpenVdbGrid* openModule(const fs::path& volume) {
  const std::string name = modulePath().string();
  try {
    const SharedLibrary library(std::span(&name, 1), "sluice's module for OpenVDB files");
    return library.get<OpenVdbGrid*>(kOpenVdbGrid);
  } catch (const Error& error) {
    fail("{}: an OpenVDB file, which is not read without {}", volume.string(), error.what());
  }
}

}  // namespace

std::unique_ptr<VolumeSource> openVdb(const fs::path& path, const std::string& grid) {
  const std::vector<VdbGridInfo> grids = readVdbGrids(path);
  const VdbGridInfo info = chooseVdbGrid(path, grids, grid);
  const VdbTreeOnDisk tree = checkVdbGrid(path, grids, info);
  const VdbOpening opening{path, info, tree, fileIdentity(path) + " grid " + info.name};
  std::unique_ptr<VolumeSource> source;
  openModule(path)(opening, source);
  return source;
}

}  // namespace sluice

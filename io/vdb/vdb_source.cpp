#include "io/vdb/vdb_source.h"

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "io/files/file.h"
#include "io/vdb/vdb_module.h"
#include "src/base/error.h"
#include "src/base/files/program_module.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

OpenVdbGrid* vdbModule(const std::string& volume) {
  try {
    return openModule({"sluice_openvdb.so", "sluice's module for OpenVDB files", kOpenVdbVersion,
                       kOpenVdbModuleVersion})
        .get<OpenVdbGrid*>(kOpenVdbGrid);
  } catch (const Error& error) {
    fail("{}: an OpenVDB file, which is not read without {}", volume, error.what());
  }
}

// Tells which of several grids is read, and if its class is none of OpenVDB's.
std::vector<std::string> notesOf(const std::string& path, const std::vector<VdbGridInfo>& grids,
                                 const VdbGridInfo& taken, const std::string& wanted) {
  std::vector<std::string> notes;
  if (grids.size() > 1 && wanted.empty())
    notes.push_back(fmt::format("{}: grid {} of {} is read; --grid takes another of {}", path,
                                taken.name, grids.size(), describe(grids)));
  const auto& known = kVdbGridClasses;
  if (!taken.grid_class.empty() && std::ranges::find(known, taken.grid_class) == known.end())
    notes.push_back(fmt::format(
        "{}: grid {} is of the class \"{}\", which is none of OpenVDB's ({}); it is read as values "
        "without a class",
        path, taken.name, taken.grid_class, fmt::join(known, ", ")));
  return notes;
}

}  // namespace

std::unique_ptr<VolumeSource> openVdb(const fs::path& path, const std::string& grid,
                                      const std::optional<Box3>& box) {
  const auto file = std::make_shared<File>(path);
  const std::vector<VdbGridInfo> grids = readVdbGrids(*file);
  const VdbGridInfo info = chooseVdbGrid(file->path(), grids, grid);
  VdbOpening opening{.path = file->path(),
                     .file = file,
                     .info = info,
                     .tree = checkVdbGrid(*file, grids, info),
                     .identity = file->identity() + " grid " + info.name,
                     .box = box,
                     .grids = {},
                     .notes = notesOf(file->path(), grids, info, grid)};
  for (const VdbGridInfo& one : grids) opening.grids.push_back(one.name);
  if (box)
    opening.identity += fmt::format(" box {},{},{} to {},{},{}", box->lo.x, box->lo.y, box->lo.z,
                                    box->hi.x, box->hi.y, box->hi.z);
  std::unique_ptr<VolumeSource> source;
  vdbModule(file->path())(opening, source);
  return source;
}

}  // namespace sluice

#include "io/zarr/packing/free_name.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "io/stores/folder_store.h"
#include "io/zarr/metadata/zarr_folder.h"
#include "io/zarr/metadata/zarr_image.h"
#include "io/zarr/reading/zarr_checksums.h"
#include "src/base/error.h"
#include "src/base/sources/level_kinds.h"

namespace sluice {

namespace fs = std::filesystem;

namespace {

// A name that a Zarr store has: metadata, our checksums, spreads and groups of levels, or a chunk's
// or array's number ("0.1.2").
bool belongsToStore(const fs::path& name) {
  const std::string text = name.string();
  constexpr std::array<std::string_view, 8> kMetadata = {
      ".zarray",   ".zgroup",          ".zattrs",         ".zmetadata",
      "zarr.json", kZarrChecksumsName, kZarrSpreadFolder, "c"};
  if (std::find(kMetadata.begin(), kMetadata.end(), text) != kMetadata.end()) return true;
  for (const LevelValues values : kLevelKinds)
    if (text == zarrLevelsFolder(values)) return true;
  return !text.empty() && text.find_first_not_of("0123456789.") == std::string::npos;
}

// Whatever is replaced is removed, so that it must be a store and nothing else.
void requireNothingForeign(const fs::path& store) {
  for (const auto& entry : fs::recursive_directory_iterator(store)) {
    if (belongsToStore(entry.path().filename()) && !entry.is_symlink()) continue;
    failRequest("{}: is not replaced, since {} is not part of a Zarr store; move it away",
                store.string(), entry.path().string());
  }
}

}  // namespace

void requireFreeName(const fs::path& output, bool replace) {
  if (withoutSlash(output).extension() != ".zarr")
    failRequest("{}: expected a name ending in .zarr", output.string());
  std::error_code problem;
  const fs::file_status status = fs::symlink_status(withoutSlash(output), problem);
  if (problem == std::errc::filename_too_long)
    failSystem("{}: cannot be written: {}", output.string(), problem.message());
  // A folder cannot be renamed over a link, not even over one that leads nowhere.
  if (fs::is_symlink(status) && !fs::exists(output, problem))
    failRequest("{}: is a link that leads to nothing; remove it or choose another name",
                output.string());
  if (!fs::exists(status)) return;
  if (!replace)
    failRequest("{}: exists; --force replaces it once the new one is whole", output.string());
  if (!isZarr(folderPlace(output)))
    failRequest("{}: is no Zarr store and is not replaced", output.string());
  requireNothingForeign(output);
}

fs::path withoutSlash(const fs::path& path) {
  const fs::path clean = path.lexically_normal();
  return clean.has_filename() ? clean : clean.parent_path();
}

}  // namespace sluice

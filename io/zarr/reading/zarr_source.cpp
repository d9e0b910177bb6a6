#include "io/zarr/reading/zarr_source.h"

#include <utility>

#include "io/headers/volume_description.h"
#include "io/stores/folder_store.h"
#include "io/zarr/metadata/zarr_folder.h"
#include "src/base/error.h"

namespace sluice {
namespace {

OpenedArray openZarrArray(const StorePlace& folder, bool is_version3) {
  const ZarrHeader header = readArrayHeader(folder, is_version3);
  OpenedArray opened;
  opened.array = std::make_unique<ZarrChunkFiles>(folder, parseZarrArray(header.text, header.path),
                                                  header.text);
  opened.identity = fmt::format("{}|{}", identityOf(folder), header.identity);
  opened.places = {header.path, folder.name()};
  opened.header_bytes = header.text.size();
  return opened;
}

// The folders of all arrays of an image: levels, their spreads, and levels of other values.
std::vector<StorePlace> arraysOf(const StorePlace& folder, const ZarrImage& image) {
  std::vector<StorePlace> groups{folder}, arrays;
  if (!image.spreads.empty()) groups.push_back(folder.at(image.spreads));
  for (const auto& group : image.level_groups) groups.push_back(folder.at(group.folder));
  for (const StorePlace& group : groups)
    for (const std::string& level : image.levels)
      // Other groups have no level 0.
      if (group.key == folder.key || level != image.levels.front())
        arrays.push_back(group.at(level));
  return arrays;
}

ChunkedVolume zarrVolume(const StorePlace& folder) {
  FoundZarr found = findZarr(folder);
  const bool is_v3 = found.is_version3;
  if (found.is_image) expectArrays(arraysOf(folder, found.image), is_v3);
  ChunkedVolume volume;
  volume.name = folder.name();
  volume.title = folder.lastPart();
  volume.said_by = found.said_by;
  volume.is_image = found.is_image;
  volume.identities = std::move(found.identities);
  volume.places = std::move(found.header_paths);
  volume.header_bytes = found.header_bytes;
  volume.notes = std::move(found.notes);
  const ZarrImage image = volume.image = std::move(found.image);
  if (std::string note = negativeSpacingNote(volume.said_by, spaceScale(image)); !note.empty())
    volume.notes.push_back(std::move(note));
  volume.open = [folder, array = found.array_folder, levels = image.levels, is_v3](size_t level) {
    return openZarrArray(level == 0 ? array : folder.at(levels[level]), is_v3);
  };
  if (!image.spreads.empty())
    volume.open_spreads = [folder, image, is_v3](size_t level) -> std::optional<OpenedArray> {
      const StorePlace place = folder.at(image.spreads).at(image.levels[level]);
      // Level 0 has some only in a group of the coarser levels of another volume.
      if (level == 0 && !isZarr(place)) return std::nullopt;
      return openZarrArray(place, is_v3);
    };
  volume.open_in_group = [folder, image, is_v3](size_t group, size_t level) {
    return openZarrArray(folder.at(image.level_groups[group].folder).at(image.levels[level]),
                         is_v3);
  };
  return volume;
}

}  // namespace

ZarrSource::ZarrSource(const std::filesystem::path& folder, const ZarrOptions& options)
    : ZarrSource(folderPlace(folder), options) {}

ZarrSource::ZarrSource(const StorePlace& folder, const ZarrOptions& options)
    : ChunkedSource(zarrVolume(folder), options) {}

}  // namespace sluice

#include "io/zarr/n5/n5_volume.h"

#include <algorithm>
#include <utility>

#include "io/headers/volume_description.h"
#include "io/zarr/metadata/zarr_folder.h"
#include "io/zarr/n5/n5_attributes.h"
#include "io/zarr/reading/zarr_chunk_files.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr const char* kAttributes = "attributes.json";
constexpr size_t kMostLevels = 64;

bool isArrayIn(const StorePlace& folder) {
  const auto header = findHeader(folder, kAttributes);
  return header && isN5Array(header->text, header->path);
}

// Attributes that tell where voxels lie; those of a group may be missing.
N5Place placeIn(const StorePlace& folder, ChunkedVolume& volume) {
  const auto header = findHeader(folder, kAttributes);
  if (!header) return {};
  volume.identities.push_back(header->identity);
  volume.places.push_back(header->path);
  volume.header_bytes += header->text.size();
  return parseN5Place(header->text, header->path);
}

size_t axesOfDataSet(const StorePlace& folder) {
  return openN5Array(folder).array->array().axes();
}

// The levels that there are, or those up to `named`.
ZarrImage imageOf(const StorePlace& group, ChunkedVolume& volume) {
  const N5Place of_group = placeIn(group, volume);
  std::vector<N5Place> levels;
  while (levels.size() < kMostLevels) {
    const StorePlace level = group.at(n5LevelName(levels.size()));
    if (!level.has(kAttributes)) break;
    levels.push_back(placeIn(level, volume));
  }
  volume.said_by = group.at(kAttributes).name();
  return n5Image(of_group, levels, axesOfDataSet(group.at(n5LevelName(0))), volume.said_by);
}

// A data set that is a level of the group around it has its place from there.
ZarrImage imageOfArray(const StorePlace& folder, ChunkedVolume& volume) {
  const StorePlace group = folder.around();
  if (folder.lastPart().starts_with('s') && isArrayIn(group.at(n5LevelName(0)))) {
    ZarrImage image = imageOf(group, volume);
    const auto at = std::find(image.levels.begin(), image.levels.end(), folder.lastPart());
    if (at != image.levels.end()) {
      const ZarrPlace& place = image.places[static_cast<size_t>(at - image.levels.begin())];
      image.scale = place.scale;
      image.translation = place.translation;
      return image;
    }
  }
  volume.said_by = folder.at(kAttributes).name();
  return n5Image({}, {placeIn(folder, volume)}, axesOfDataSet(folder), volume.said_by);
}

// A name inside the folder that could be opened instead; empty when there is none.
std::string nameInside(const StorePlace& folder) {
  if (!folder.store->canList()) return "";
  std::string least;
  folder.store->list(folder.key, [&](const ChunkStore::Entry& entry) {
    if (entry.is_folder && (least.empty() || entry.name < least) && isN5(folder.at(entry.name)))
      least = entry.name;
  });
  return least.empty() ? "" : fmt::format("; it holds others, such as {}", folder.at(least).name());
}

}  // namespace

OpenedArray openN5Array(const StorePlace& folder) {
  const auto header = findHeader(folder, kAttributes);
  if (!header)
    fail("{}: expected a data set's attributes, found none", folder.at(kAttributes).name());
  OpenedArray opened;
  opened.array = std::make_unique<ZarrChunkFiles>(folder, parseN5Array(header->text, header->path),
                                                  header->text);
  opened.identity = fmt::format("{}|{}", identityOf(folder), header->identity);
  opened.places = {header->path, folder.name()};
  opened.header_bytes = header->text.size();
  return opened;
}

std::vector<Vec3d> n5Factors(const StorePlace& setup, const StorePlace& time_point) {
  ChunkedVolume read;
  std::vector<std::vector<double>> all = placeIn(setup, read).factors;
  if (all.empty())
    // Without a list in the set-up, each level tells its own.
    while (all.size() < kMostLevels) {
      const StorePlace level = time_point.at(n5LevelName(all.size()));
      if (!level.has(kAttributes)) break;
      const N5Place own = placeIn(level, read);
      // s0 needs no factors; a gap further on ends the levels.
      if (own.factors.size() != 1 && !all.empty()) break;
      all.push_back(own.factors.size() == 1 ? own.factors[0] : std::vector<double>{1, 1, 1});
    }
  std::vector<Vec3d> factors;
  for (const std::vector<double>& of_level : all) {
    const bool is_sound =
        of_level.size() == 3 && *std::min_element(of_level.begin(), of_level.end()) >= 1;
    if (!is_sound)
      fail("{}: expected 3 downsamplingFactors of 1 or more for each level, found others",
           setup.name());
    factors.push_back({of_level[0], of_level[1], of_level[2]});
  }
  if (factors.empty())
    fail("{}: expected levels s0, s1 ... of a set-up, found none", time_point.name());
  return factors;
}

bool isN5(const StorePlace& folder) {
  return folder.has(kAttributes) || folder.at(n5LevelName(0)).has(kAttributes);
}

ChunkedVolume n5Volume(const StorePlace& folder) {
  ChunkedVolume volume;
  volume.name = folder.name();
  volume.title = folder.lastPart();
  const auto noteSpacing = [&volume] {
    if (std::string note = negativeSpacingNote(volume.said_by, spaceScale(volume.image));
        !note.empty())
      volume.notes.push_back(std::move(note));
  };
  if (isArrayIn(folder)) {
    volume.image = imageOfArray(folder, volume);
    noteSpacing();
    volume.open = [folder](size_t) { return openN5Array(folder); };
    return volume;
  }
  if (!isArrayIn(folder.at(n5LevelName(0))))
    fail("{}: expected a data set or a group of levels s0, s1 ..., found an N5 group of neither{}",
         volume.name, nameInside(folder));
  volume.image = imageOf(folder, volume);
  noteSpacing();
  volume.is_image = true;
  volume.open = [folder](size_t level) { return openN5Array(folder.at(n5LevelName(level))); };
  return volume;
}

}  // namespace sluice

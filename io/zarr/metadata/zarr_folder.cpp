#include "io/zarr/metadata/zarr_folder.h"

#include <algorithm>
#include <span>
#include <utility>

#include "io/zarr/reading/zarr_checksums.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"

namespace sluice {

namespace {

constexpr uint64_t kMostHeaderBytes = 16 << 20;
constexpr const char* kVersion3 = "zarr.json";
constexpr int kMostLevelDepth = 2;  // folders between an image's and its level's, that one included

// The file of a folder that may describe an image.
std::optional<ZarrHeader> findAttributes(const StorePlace& folder) {
  for (const char* name : {".zattrs", kVersion3})
    if (std::optional<ZarrHeader> header = findHeader(folder, name)) return header;
  return std::nullopt;
}

const char* headerName(bool is_version3) {
  return is_version3 ? kVersion3 : ".zarray";
}

bool isVersion3(const ZarrHeader& header) {
  return header.path.ends_with(kVersion3);
}

// A line about arrays beside this one that have the names of its axes, as xarray keeps the
// positions along them; empty: there are none.
std::string coordinatesNote(const StorePlace& folder, const ZarrImage& image) {
  const StorePlace around = folder.around();
  if (around.key == folder.key) return "";
  std::vector<std::string> names;
  for (const ZarrAxis& axis : image.axes) {
    // A name may have any letters.
    if (axis.name.find('/') != std::string::npos || axis.name.starts_with(".")) continue;
    const StorePlace beside = around.at(axis.name);
    if (axis.type != "time" && axis.name != "time" &&
        (beside.has(".zarray") || beside.has(kVersion3)))
      names.push_back(printable(beside.name(), kLongestName));
  }
  if (names.empty()) return "";
  return fmt::format(
      "{}: the coordinates of its axes ({}) are not read: its voxels are drawn 1 apart, unless you "
      "give --spacing",
      folder.name(), fmt::join(names, ", "));
}

// An array by itself, or one of the levels of the image around it.
FoundZarr findArray(const StorePlace& folder) {
  FoundZarr found;
  found.array_folder = folder;
  found.said_by = folder.at(folder.has(".zarray") ? ".zarray" : kVersion3).name();
  // The levels of some programs lie one folder deeper, as in scale0/image.
  std::string level;
  StorePlace around = folder;
  for (int depth = 0; depth < kMostLevelDepth; ++depth) {
    level = level.empty() ? around.lastPart() : fmt::format("{}/{}", around.lastPart(), level);
    const StorePlace outside = around.around();
    // The top of the store has nothing around it.
    if (outside.key == around.key) break;
    around = outside;
    const std::optional<ZarrHeader> header = findAttributes(around);
    if (!header) continue;
    const auto levels = parseZarrImage(header->text, header->path).levels;
    if (std::find(levels.begin(), levels.end(), level) == levels.end()) continue;
    found.image = parseZarrImage(header->text, header->path, level);
    found.said_by = header->path;
    found.take(*header);
    return found;
  }
  // Names of axes may stand beside an array (_ARRAY_DIMENSIONS, dimension_names).
  if (const std::optional<ZarrHeader> own = findAttributes(folder)) {
    found.image = parseZarrImage(own->text, own->path);
    if (!isVersion3(*own)) found.take(*own);  // the array's own header otherwise
    if (std::string note = coordinatesNote(folder, found.image); !note.empty())
      found.notes.push_back(std::move(note));
  }
  return found;
}

// A name inside the folder that could be opened instead; empty when there is none.
std::string insideOf(const StorePlace& folder) {
  if (!folder.store->canList()) return "";
  std::string least;
  // The least name, so that messages do not hang on the order in which a disk lists.
  folder.store->list(folder.key, [&](const ChunkStore::Entry& entry) {
    if (isZarr(folder.at(entry.name)) && (least.empty() || entry.name < least)) least = entry.name;
  });
  return least.empty() ? "" : fmt::format("; it holds others, such as {}", folder.at(least).name());
}

}  // namespace

std::optional<ZarrHeader> findHeader(const StorePlace& folder, const char* name) {
  const StorePlace place = folder.at(name);
  // A server's store keeps what it was asked for so.
  if (!place.store->has(place.key)) return std::nullopt;
  ZarrHeader header{place.name(), {}, {}};
  const bool is_there = place.store->read(place.key, {}, [&](const PieceInfo& piece) {
    if (piece.bytes > kMostHeaderBytes)
      fail("{}: expected at most {} bytes, found {}", header.path, kMostHeaderBytes, piece.bytes);
    header.text.resize(piece.bytes);
    return std::as_writable_bytes(std::span(header.text));
  });
  if (!is_there) return std::nullopt;
  // A rewritten header may keep its size and, where clocks are coarse, its time: its checksum
  // tells.
  header.identity = fmt::format("{}|{:016x}", identityOf(place),
                                zarrChecksum(std::as_bytes(std::span(header.text))));
  return header;
}

void FoundZarr::take(const ZarrHeader& header) {
  identities.push_back(header.identity);
  header_paths.push_back(header.path);
  header_bytes += header.text.size();
}

std::string identityOf(const StorePlace& place) {
  return fmt::format("{}|{}", place.store->wholeKey(place.key), place.store->stampOf(place.key));
}

bool isZarr(const StorePlace& folder) {
  return folder.has(kVersion3) || folder.has(".zarray") || folder.has(".zgroup");
}

ZarrHeader readArrayHeader(const StorePlace& array_folder, bool is_version3) {
  // An image's header of one version may stand above arrays of the other.
  for (const char* name : {headerName(is_version3), headerName(!is_version3)})
    if (std::optional<ZarrHeader> header = findHeader(array_folder, name)) return *header;
  fail("{}: expected an array's header, there or in zarr.json; found none",
       array_folder.at(".zarray").name());
}

void expectArrays(const std::vector<StorePlace>& array_folders, bool is_version3) {
  if (array_folders.empty()) return;
  std::vector<std::string> keys;
  for (const StorePlace& folder : array_folders) {
    keys.push_back(folder.at(headerName(is_version3)).key);
    // The first, of the finest level, may be large, and a store keeps what it expects.
    if (&folder != &array_folders.front())
      keys.push_back(folder.at(std::string(kZarrChecksumsName)).key);
  }
  array_folders.front().store->expect(keys);
}

FoundZarr findZarr(const StorePlace& folder) {
  if (folder.has(".zarray")) return findArray(folder);
  FoundZarr found;
  if (const std::optional<ZarrHeader> header = findAttributes(folder)) {
    if (isVersion3(*header) && isZarrArray(header->text, header->path)) return findArray(folder);
    found.image = parseZarrImage(header->text, header->path);
    found.said_by = header->path;
    found.is_version3 = isVersion3(*header);
    found.take(*header);
  }
  if (found.image.levels.empty())
    fail(
        "{}: expected an image (multiscales in .zattrs or zarr.json) or an array, found a Zarr "
        "group of neither{}",
        folder.name(), insideOf(folder));
  found.array_folder = folder.at(found.image.levels[0]);
  found.is_image = true;
  return found;
}

}  // namespace sluice

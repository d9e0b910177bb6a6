#include "io/zarr/zarr_folder.h"

#include <algorithm>
#include <span>

#include "io/files/file.h"
#include "src/base/error.h"

namespace sluice {

namespace fs = std::filesystem;

namespace {

constexpr uint64_t kMostHeaderBytes = 16 << 20;
constexpr const char* kVersion3 = "zarr.json";
constexpr int kMostLevelDepth = 2;  // folders between an image's and its level's, that one included

ZarrHeader readHeader(const fs::path& path) {
  File file(path);
  if (file.sizeBytes() > kMostHeaderBytes)
    fail("{}: expected at most {} bytes, found {}", path.string(), kMostHeaderBytes,
         file.sizeBytes());
  ZarrHeader header{path.string(), std::string(static_cast<size_t>(file.sizeBytes()), '\0'),
                    file.identity()};
  file.readAt(0, std::as_writable_bytes(std::span(header.text)));
  return header;
}

bool has(const fs::path& folder, const char* name) {
  std::error_code ignored;
  return fs::exists(folder / name, ignored);
}

// The file of a folder that may describe an image: empty if there is none.
fs::path attributesOf(const fs::path& folder) {
  for (const char* name : {".zattrs", kVersion3})
    if (has(folder, name)) return folder / name;
  return {};
}

// An array by itself, or one of the levels of the image around it.
FoundZarr findArray(const fs::path& folder) {
  FoundZarr found;
  found.array_folder = folder;
  found.said_by = (folder / (has(folder, ".zarray") ? ".zarray" : kVersion3)).string();
  const fs::path whole = fs::absolute(folder).lexically_normal();
  const fs::path clean = whole.has_filename() ? whole : whole.parent_path();
  // The levels of some programs lie one folder deeper, as in scale0/image.
  fs::path level, around = clean;
  for (int depth = 0; depth < kMostLevelDepth; ++depth) {
    level = level.empty() ? around.filename() : around.filename() / level;
    around = around.parent_path();
    const fs::path said_by = attributesOf(around);
    if (said_by.empty()) continue;
    const ZarrHeader header = readHeader(said_by);
    const auto levels = parseZarrImage(header.text, header.path).levels;
    if (std::find(levels.begin(), levels.end(), level.string()) == levels.end()) continue;
    found.image = parseZarrImage(header.text, header.path, level.string());
    found.said_by = header.path;
    found.take(header);
    return found;
  }
  if (const fs::path own = attributesOf(folder); !own.empty()) {
    const ZarrHeader header = readHeader(own);
    found.image = parseZarrImage(header.text, header.path);
    if (own.filename() != kVersion3) found.take(header);  // the array's own header otherwise
  }
  return found;
}

// A name inside the folder that could be opened instead; empty when there is none.
std::string insideOf(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code status;
  fs::directory_iterator entries(folder, status);
  for (; !status && entries != fs::directory_iterator(); entries.increment(status))
    if (isZarr(entries->path())) names.push_back(entries->path().filename().string());
  if (names.empty()) return "";
  return fmt::format("; it holds others, such as {}",
                     (folder / *std::min_element(names.begin(), names.end())).string());
}

}  // namespace

void FoundZarr::take(const ZarrHeader& header) {
  identities.push_back(header.identity);
  header_paths.push_back(header.path);
  header_bytes += header.text.size();
}

bool isZarr(const fs::path& folder) {
  return has(folder, ".zarray") || has(folder, ".zgroup") || has(folder, kVersion3);
}

ZarrHeader readArrayHeader(const fs::path& array_folder) {
  const bool is_old = has(array_folder, ".zarray") || !has(array_folder, kVersion3);
  return readHeader(array_folder / (is_old ? ".zarray" : kVersion3));
}

FoundZarr findZarr(const fs::path& folder) {
  if (has(folder, ".zarray")) return findArray(folder);
  FoundZarr found;
  if (const fs::path said_by = attributesOf(folder); !said_by.empty()) {
    const ZarrHeader header = readHeader(said_by);
    if (said_by.filename() == kVersion3 && isZarrArray(header.text, header.path))
      return findArray(folder);
    found.image = parseZarrImage(header.text, header.path);
    found.said_by = header.path;
    found.take(header);
  }
  if (found.image.levels.empty())
    fail(
        "{}: expected an image (multiscales in .zattrs or zarr.json) or an array, found a Zarr "
        "group of neither{}",
        folder.string(), insideOf(folder));
  found.array_folder = folder / found.image.levels[0];
  found.is_image = true;
  return found;
}

FoundZarr datasetOf(const FoundZarr& image, const fs::path& array_folder, size_t number) {
  FoundZarr found;
  found.array_folder = array_folder;
  found.image = image.image;
  found.image.scale = image.image.places[number].scale;
  found.image.translation = image.image.places[number].translation;
  found.said_by = image.said_by;
  return found;
}

}  // namespace sluice

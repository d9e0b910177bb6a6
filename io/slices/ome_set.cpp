#include "io/slices/ome_set.h"

#include <system_error>

#include "io/slices/ome_description.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/files/text_file.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// A file of the set by its name. A description may not lead to other folders.
fs::path besideFile(const fs::path& file, const std::string& name) {
  const fs::path plain = fs::path(name).filename();
  const std::string where = file.string(), said = printable(name, 200);
  if (name.empty() || plain.string() != name || name == "." || name == "..")
    fail("{}: its OME description names the file '{}', expected a name without folders", where,
         said);
  fs::path path = file.parent_path() / plain;
  std::error_code unknown;
  if (!fs::is_regular_file(path, unknown))
    fail(
        "{}: its OME description names {}, which is missing; put all files of the set into one "
        "folder",
        where, said);
  return path;
}

}  // namespace

PageOrder orderWithCompanion(const fs::path& file, PageOrder order, int64_t pages) {
  if (order.companion.empty()) return order;
  constexpr uint64_t kMostBytes = uint64_t{256} << 20;
  const fs::path companion = besideFile(file, order.companion);
  PageOrder whole = parseOmeDescription(
      readTextFile(companion, kMostBytes, "the OME description of a set"), pages);
  if (!whole.is_described)
    fail("{}: expected the OME description of the set that {} belongs to, found none",
         companion.string(), file.string());
  return whole;
}

std::vector<fs::path> filesOfSet(const fs::path& file, const PageOrder& order) {
  std::vector<fs::path> files;
  for (const std::string& name : order.files) files.push_back(besideFile(file, name));
  return files;
}

}  // namespace sluice

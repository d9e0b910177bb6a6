#include "io/vdb_header.h"

#include <cstddef>

#include "io/file.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMagic = 0x56444220;
constexpr uint32_t kFirstVersionWithTextUuid = 218;
constexpr uint32_t kFirstVersionWithCompressionByte = 220;
constexpr uint32_t kFirstVersionWithNodeMasks = 222;
constexpr uint32_t kMaxGrids = 1 << 20;

// Reads a file from its start, with every size held against what is left of it.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : file_(path) {}

  uint64_t size() const { return file_.sizeBytes(); }
  uint64_t position() const { return position_; }

  void read(void* to, uint64_t bytes) {
    need(bytes);
    file_.readAt(position_, {static_cast<std::byte*>(to), bytes});
    position_ += bytes;
  }
  template <class T>
  T number() {
    T value{};
    read(&value, sizeof value);
    return value;
  }
  std::string text() {
    const auto bytes = number<uint32_t>();
    need(bytes);
    std::string value(bytes, '\0');
    read(value.data(), bytes);
    return value;
  }
  void skip(uint64_t bytes) {
    need(bytes);
    seek(position_ + bytes);
  }
  void seek(uint64_t position) {
    if (position > size()) cutShort(position);
    position_ = position;
  }

 private:
  void need(uint64_t bytes) const {
    if (bytes > size() - position_) cutShort(position_ + bytes);
  }
  [[noreturn]] void cutShort(uint64_t needed) const {
    fail("{}: OpenVDB file cut short or damaged: it needs byte {} but has {}", file_.path(), needed,
         size());
  }

  File file_;
  uint64_t position_ = 0;
};

// Walks a block of named metadata; returns the value of the string called "class".
std::string readClass(Reader& reader) {
  std::string grid_class;
  const auto count = reader.number<uint32_t>();
  for (uint32_t i = 0; i < count; ++i) {
    const std::string key = reader.text();
    const std::string type = reader.text();
    if (key == "class" && type == "string") {
      grid_class = reader.text();
    } else {
      reader.skip(reader.number<uint32_t>());
    }
  }
  return grid_class;
}

// "Tree_float_5_4_3" -> "float"; other names unchanged.
std::string valueTypeOf(const std::string& tree_type) {
  const std::string prefix = "Tree_";
  if (!tree_type.starts_with(prefix)) return tree_type;
  return tree_type.substr(prefix.size(), tree_type.find('_', prefix.size()) - prefix.size());
}

// OpenVDB tells grids of one name apart by a number after an ASCII record separator.
std::string readableName(std::string unique) {
  const size_t separator = unique.find('\x1e');
  if (separator == std::string::npos) return unique;
  return unique.substr(0, separator) + "[" + unique.substr(separator + 1) + "]";
}

VdbGridInfo readGrid(Reader& reader, const std::filesystem::path& path, uint32_t version) {
  VdbGridInfo grid;
  grid.name = readableName(reader.text());
  std::string tree_type = reader.text();
  const std::string half_suffix = "_HalfFloat";
  if (tree_type.ends_with(half_suffix)) {
    grid.saved_as_half = true;
    tree_type.resize(tree_type.size() - half_suffix.size());
  }
  grid.value_type = valueTypeOf(tree_type);
  grid.is_instance = !reader.text().empty();
  const auto grid_at = reader.number<uint64_t>();
  const auto values_at = reader.number<uint64_t>();
  const auto end = reader.number<uint64_t>();
  if (grid_at < reader.position() || values_at < grid_at || end < values_at)
    fail("{}: damaged OpenVDB file: grid \"{}\" lies at {} to {} with its values at {}",
         path.string(), grid.name, grid_at, end, values_at);
  grid.topology_bytes = values_at - grid_at;
  grid.value_bytes = end - values_at;

  reader.seek(grid_at);
  if (version >= kFirstVersionWithNodeMasks) reader.number<uint32_t>();  // compression
  grid.grid_class = readClass(reader);
  reader.seek(end);
  return grid;
}

}  // namespace

std::vector<VdbGridInfo> readVdbGrids(const std::filesystem::path& path) {
  Reader reader(path);
  if (reader.size() < sizeof kMagic || reader.number<uint64_t>() != kMagic)
    fail("{}: not an OpenVDB file (its first bytes are not OpenVDB's)", path.string());
  const auto version = reader.number<uint32_t>();
  if (version < kFirstVersionWithTextUuid)
    fail("{}: OpenVDB file format {}, expected {} or later; write it again with a newer OpenVDB",
         path.string(), version, kFirstVersionWithTextUuid);
  reader.skip(2 * sizeof(uint32_t));  // the library's version
  const bool has_table = reader.number<uint8_t>() != 0;
  if (version >= kFirstVersionWithCompressionByte && version < kFirstVersionWithNodeMasks)
    reader.skip(1);
  constexpr uint64_t kUuidBytes = 36;
  reader.skip(kUuidBytes);
  readClass(reader);  // the file's own metadata
  if (!has_table)
    fail(
        "{}: OpenVDB file without a table of its grids (written through a pipe); "
        "write it again with vdb_tool -read IN.vdb -write OUT.vdb",
        path.string());

  const auto count = reader.number<uint32_t>();
  if (count > kMaxGrids) fail("{}: damaged OpenVDB file: it states {} grids", path.string(), count);
  std::vector<VdbGridInfo> grids;
  for (uint32_t i = 0; i < count; ++i) grids.push_back(readGrid(reader, path, version));
  return grids;
}

std::string describe(const std::vector<VdbGridInfo>& grids) {
  std::string text;
  for (const VdbGridInfo& grid : grids) {
    text += fmt::format("{}{} ({}{}{})", text.empty() ? "" : ", ", grid.name, grid.value_type,
                        grid.grid_class.empty() ? "" : ", ", grid.grid_class);
  }
  return text.empty() ? "none" : text;
}

}  // namespace sluice

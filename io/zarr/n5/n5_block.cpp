#include "io/zarr/n5/n5_block.h"

#include <algorithm>
#include <cstring>

#include "src/base/error.h"

namespace sluice {
namespace {

// Numbers of a block's header, which are big-endian.
class HeaderReader {
 public:
  HeaderReader(std::span<const std::byte> bytes, const std::string& path)
      : rest_(bytes), path_(path) {}

  uint64_t number(size_t bytes) {
    if (rest_.size() < bytes) fail("{}: expected a block's header, found it cut short", path_);
    uint64_t value = 0;
    for (size_t i = 0; i < bytes; ++i) value = value << 8 | static_cast<uint64_t>(rest_[i]);
    rest_ = rest_.subspan(bytes);
    return value;
  }
  std::span<const std::byte> rest() const { return rest_; }

 private:
  std::span<const std::byte> rest_;
  const std::string& path_;
};

}  // namespace

void checkN5Size(uint64_t stored_bytes, uint64_t chunk_bytes, const std::string& path) {
  constexpr uint64_t kHeaders = 4096;
  // Numbers that cannot be compressed grow a little; more than that is damage.
  const uint64_t most = chunk_bytes + chunk_bytes / 16 + kHeaders;
  if (stored_bytes > most)
    fail("{}: expected at most {} bytes for a block of {}, found {}", path, most, chunk_bytes,
         stored_bytes);
}

N5Block parseN5Block(const ZarrArray& array, int64_t chunk, std::span<const std::byte> file,
                     const std::string& path) {
  constexpr uint64_t kDefault = 0, kVarLength = 1;
  HeaderReader header(file, path);
  const uint64_t mode = header.number(2);
  if (mode != kDefault && mode != kVarLength)
    fail("{}: expected a block of mode 0 or 1, found {}", path, mode);
  const uint64_t axes = header.number(2);
  if (axes != array.axes())
    fail("{}: expected a block of {} axes, found {}", path, array.axes(), axes);
  N5Block block;
  for (size_t a = 0; a < axes; ++a) block.extents.push_back(static_cast<int64_t>(header.number(4)));
  std::reverse(block.extents.begin(), block.extents.end());
  const std::vector<int64_t> index = array.chunkIndex(chunk);
  uint64_t voxels = 1;
  for (size_t a = 0; a < axes; ++a) {
    const int64_t whole = array.chunks[a];
    // Some writers cut the last blocks of an axis to the array, others store them whole.
    const int64_t least = std::min(whole, array.shape[a] - index[a] * whole);
    if (block.extents[a] < least || block.extents[a] > whole)
      fail("{}: expected a block of {} to {} voxels along axis {}, found {}", path, least, whole,
           axes - 1 - a, block.extents[a]);
    voxels *= static_cast<uint64_t>(block.extents[a]);
  }
  // The count of mode 1 is of elements, which are single numbers in what is read here.
  if (mode == kVarLength)
    if (const uint64_t said = header.number(4); said != voxels)
      fail("{}: expected a block of {} voxels, as its extents are, found {}", path, voxels, said);
  block.bytes = voxels * bytesPerVoxel(array.type);
  block.stored = header.rest();
  if (array.codec == ZarrCodec::kNone && block.stored.size() != block.bytes)
    fail("{}: expected {} bytes after the block's header, found {}", path, block.bytes,
         block.stored.size());
  return block;
}

void spreadN5Block(const ZarrArray& array, const N5Block& block, std::span<std::byte> chunk) {
  const size_t axes = array.axes(), last = axes - 1;
  int64_t rows = 1;
  for (size_t a = 0; a < last; ++a) rows *= block.extents[a];
  const size_t row_bytes = static_cast<size_t>(block.extents[last]) * bytesPerVoxel(array.type);
  // From the last row on, as none moves to the front.
  for (int64_t row = rows - 1; row >= 0; --row) {
    int64_t rest = row, to = 0, stride = array.chunks[last];
    for (size_t a = last; a-- > 0;) {
      to += rest % block.extents[a] * stride;
      rest /= block.extents[a];
      stride *= array.chunks[a];
    }
    std::memmove(chunk.data() + static_cast<size_t>(to) * bytesPerVoxel(array.type),
                 chunk.data() + static_cast<size_t>(row) * row_bytes, row_bytes);
  }
}

}  // namespace sluice

#include "io/zarr/metadata/zarr_array.h"

#include <algorithm>

#include "src/base/values/vec.h"

namespace sluice {
namespace {

// Parts of these extents along an axis of the array.
int64_t along(const ZarrArray& array, std::span<const int64_t> parts, size_t axis) {
  return ceilDiv(array.shape[axis], parts[axis]);
}

int64_t countOf(const ZarrArray& array, std::span<const int64_t> parts) {
  int64_t count = 1;
  for (size_t a = 0; a < array.axes(); ++a) count *= along(array, parts, a);
  return count;
}

int64_t numberOf(const ZarrArray& array, std::span<const int64_t> parts,
                 std::span<const int64_t> index) {
  int64_t number = 0;
  for (size_t a = 0; a < array.axes(); ++a) number = number * along(array, parts, a) + index[a];
  return number;
}

std::vector<int64_t> indexOf(const ZarrArray& array, std::span<const int64_t> parts,
                             int64_t number) {
  std::vector<int64_t> index(array.axes());
  for (size_t a = array.axes(); a-- > 0;) {
    index[a] = number % along(array, parts, a);
    number /= along(array, parts, a);
  }
  return index;
}

}  // namespace

uint64_t ZarrArray::chunkBytes() const {
  uint64_t bytes = bytesPerVoxel(type);
  for (const int64_t extent : chunks) bytes *= static_cast<uint64_t>(extent);
  return bytes;
}

int64_t ZarrArray::chunkCount() const {
  return countOf(*this, chunks);
}

int64_t ZarrArray::chunkNumber(std::span<const int64_t> index) const {
  return numberOf(*this, chunks, index);
}

std::vector<int64_t> ZarrArray::chunkIndex(int64_t number) const {
  return indexOf(*this, chunks, number);
}

int64_t ZarrArray::fileCount() const {
  return countOf(*this, files);
}

int64_t ZarrArray::filesAlong(size_t axis) const {
  return along(*this, files, axis);
}

int64_t ZarrArray::fileNumber(std::span<const int64_t> index) const {
  return numberOf(*this, files, index);
}

std::vector<int64_t> ZarrArray::fileIndex(int64_t number) const {
  return indexOf(*this, files, number);
}

std::string ZarrArray::fileName(int64_t number) const {
  std::string name = prefix;
  std::vector<int64_t> index = fileIndex(number);
  // N5 names axes from the fastest, against the order of shapes here.
  if (is_n5) std::reverse(index.begin(), index.end());
  for (const int64_t i : index) {
    if (!name.empty()) name += separator;
    name += std::to_string(i);
  }
  return name;
}

ZarrArray::Place ZarrArray::placeOf(int64_t chunk) const {
  if (!shards) return {chunk, 0};
  std::vector<int64_t> index = chunkIndex(chunk);
  Place place;
  // Chunks of a shard are counted in C order, whatever the array's own order (sharding_indexed).
  for (size_t a = 0; a < axes(); ++a) {
    const int64_t inside = files[a] / chunks[a];
    place.chunk = place.chunk * inside + index[a] % inside;
    index[a] /= inside;
  }
  place.file = fileNumber(index);
  return place;
}

int64_t ZarrArray::chunksAFile() const {
  int64_t count = 1;
  for (size_t a = 0; a < axes(); ++a) count *= files[a] / chunks[a];
  return count;
}

uint64_t ZarrArray::shardIndexBytes() const {
  constexpr uint64_t kEntryBytes = 16, kCrcBytes = 4;
  return static_cast<uint64_t>(chunksAFile()) * kEntryBytes + (shards->has_crc ? kCrcBytes : 0);
}

}  // namespace sluice

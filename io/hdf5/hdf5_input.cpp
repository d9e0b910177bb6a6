#include "io/hdf5/hdf5_input.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

#include "io/files/swap_bytes.h"
#include "io/hdf5/hdf5_filters.h"
#include "src/base/error.h"
#include "src/base/files/program_module.h"
#include "src/base/sources/volume_source.h"

namespace sluice {
namespace {

constexpr size_t kLeastAxes = 3;

std::shared_ptr<Hdf5File> openFile(const std::string& path) {
  OpenHdf5* open = nullptr;
  try {
    open = openModule(
               {"sluice_hdf5.so", "sluice's module for HDF5", kOpenHdf5Version, kHdf5ModuleVersion})
               .get<OpenHdf5*>(kOpenHdf5);
  } catch (const Error& error) {
    fail("{}: an HDF5 file, which is not read without {}", path, error.what());
  }
  std::shared_ptr<Hdf5File> file;
  open(path, file);
  return file;
}

class Hdf5Array final : public ChunkedArray {
 public:
  Hdf5Array(std::shared_ptr<File> file, std::unique_ptr<Hdf5Set> set, std::string name,
            ZarrArray array)
      : file_(std::move(file)),
        set_(std::move(set)),
        name_(std::move(name)),
        array_(std::move(array)),
        is_by_library_(set_->description().chunks.empty() ||
                       !areKnownFilters(set_->description().filters)) {}

  const ZarrArray& array() const override { return array_; }
  bool areKnown() const override { return false; }
  const std::vector<int64_t>& existing() override { SLUICE_CHECK(false); }
  bool exists(int64_t chunk) override {
    return set_->description().chunks.empty() || set_->storedBytes(cornerOf(chunk)) > 0;
  }
  std::shared_ptr<CountedBytes> load(int64_t chunk, ChunkMemory& memory) override {
    auto decoded = std::make_shared<CountedBytes>(array_.chunkBytes(), memory);
    if (is_by_library_)
      readBox(chunk, decoded->span());
    else
      readChunk(chunk, decoded->span());
    requireUnchanged();
    if (array_.byte_order != std::endian::native)
      swapBytes(decoded->span(), bytesPerVoxel(array_.type));
    return decoded;
  }
  std::string stamp() const override { return file_->identity(); }
  uint64_t storedBytesRead() const override { return read_bytes_; }

 private:
  std::vector<int64_t> cornerOf(int64_t chunk) const {
    std::vector<int64_t> corner = array_.chunkIndex(chunk);
    for (size_t a = 0; a < corner.size(); ++a) corner[a] *= array_.chunks[a];
    // The data set may have fewer axes than the volume.
    const size_t added = corner.size() - set_->description().shape.size();
    corner.erase(corner.begin(), corner.begin() + static_cast<std::ptrdiff_t>(added));
    return corner;
  }

  void readChunk(int64_t chunk, std::span<std::byte> out) {
    const std::vector<int64_t> corner = cornerOf(chunk);
    const uint64_t bytes = set_->storedBytes(corner);
    const std::string path =
        fmt::format("{}: the chunk from ({}) on", name_, fmt::join(corner, ", "));
    const std::vector<Hdf5Filter>& filters = set_->description().filters;
    if (filters.empty()) {
      if (bytes != out.size()) fail("{}: expected {} bytes, found {}", path, out.size(), bytes);
      set_->readStored(corner, out);
    } else {
      // A compressor adds little to what it cannot shrink, so a larger chunk is damaged; this
      // bounds the memory for it.
      const uint64_t most = out.size() + out.size() / 16 + 4096;
      if (bytes == 0 || bytes > most)
        fail("{}: expected 1 to {} bytes, found {}", path, most, bytes);
      std::vector<std::byte> stored(bytes);
      const uint32_t mask = set_->readStored(corner, stored);
      undoFilters(filters, mask, stored, out, path);
    }
    read_bytes_ += bytes;
  }

  void readBox(int64_t chunk, std::span<std::byte> out) {
    const std::vector<int64_t> corner = cornerOf(chunk);
    const std::vector<int64_t>& shape = set_->description().shape;
    const size_t added = array_.axes() - shape.size();
    std::vector<int64_t> extents;
    uint64_t bytes = bytesPerVoxel(array_.type);
    for (size_t a = 0; a < shape.size(); ++a) {
      extents.push_back(std::min(array_.chunks[added + a], shape[a] - corner[a]));
      bytes *= static_cast<uint64_t>(extents.back());
    }
    set_->readBox(corner, extents, out.first(bytes));
    read_bytes_ += bytes;
    if (bytes == out.size()) return;
    // Rows to their places in a whole chunk, from the last on.
    const size_t last = shape.size() - 1;
    const size_t row_bytes = static_cast<size_t>(extents[last]) * bytesPerVoxel(array_.type);
    // Each row moves to a place behind its own, so the last one goes first.
    for (auto row = static_cast<int64_t>(bytes / row_bytes) - 1; row >= 0; --row) {
      int64_t rest = row, to = 0, stride = array_.chunks[added + last];
      for (size_t a = last; a-- > 0;) {
        to += rest % extents[a] * stride;
        rest /= extents[a];
        stride *= array_.chunks[added + a];
      }
      std::memmove(out.data() + static_cast<size_t>(to) * bytesPerVoxel(array_.type),
                   out.data() + static_cast<size_t>(row) * row_bytes, row_bytes);
    }
  }

  // Reads a byte, before which the file is compared with what it was.
  void requireUnchanged() {
    std::array<std::byte, 1> front;
    // HDF5 reads by itself, so that File's own check does not see those reads.
    file_->readAt(0, front);
  }

  const std::shared_ptr<File> file_;
  const std::unique_ptr<Hdf5Set> set_;
  const std::string name_;
  const ZarrArray array_;
  const bool is_by_library_;
  std::atomic<uint64_t> read_bytes_{0};
};

// Sizes of chunks, of a set without them about a quarter of a MiB of rows.
std::vector<int64_t> chunksOf(const Hdf5Description& description) {
  if (!description.chunks.empty()) return description.chunks;
  constexpr int64_t kVoxels = 1 << 18;
  std::vector<int64_t> chunks(description.shape.size(), 1);
  int64_t voxels = 1;
  for (size_t a = chunks.size(); a-- > 0 && voxels < kVoxels;) {
    chunks[a] = std::min(description.shape[a], std::max<int64_t>(1, kVoxels / voxels));
    voxels *= chunks[a];
  }
  return chunks;
}

}  // namespace

bool isHdf5(std::string_view head) {
  using namespace std::string_view_literals;
  for (const size_t at : {0, 512, 1024, 2048})  // behind a block of the user's
    if (head.size() > at && head.substr(at).starts_with("\x89HDF\r\n\x1a\n"sv)) return true;
  return false;
}

Hdf5Input openHdf5Input(const std::string& path) {
  Hdf5Input input;
  input.file = std::make_shared<File>(path);
  input.inside = openFile(path);
  return input;
}

const Hdf5Attribute* find(const std::vector<Hdf5Attribute>& attributes, std::string_view name) {
  for (const Hdf5Attribute& attribute : attributes)
    if (attribute.name == name) return &attribute;
  return nullptr;
}

ZarrArray hdf5ArrayOf(const Hdf5Description& description, const std::string& name) {
  for (const Hdf5Filter& filter : description.filters)
    // A filter that is in the library is left to it, which decodes one chunk at a time.
    if (!areKnownFilters(description.filters) && !filter.is_in_library)
      fail("{}: expected chunks packed with deflate, LZF, LZ4, zstd or Blosc, found {} (filter {})",
           name, filter.name, filter.number);
  ZarrArray array;
  array.shape = description.shape;
  array.chunks = chunksOf(description);
  for (std::vector<int64_t>* extents : {&array.shape, &array.chunks})
    while (extents->size() < kLeastAxes) extents->insert(extents->begin(), 1);
  array.files = array.chunks;
  array.order.resize(array.axes());
  std::iota(array.order.begin(), array.order.end(), size_t{0});
  array.type = description.type;
  array.byte_order = description.byte_order;
  array.fill_value = description.fill_value;
  int64_t voxels = 1, chunk = 1;
  for (size_t a = 0; a < array.axes(); ++a) {
    if (array.shape[a] < 1) fail("{}: expected one voxel or more, found none", name);
    // Sizes come from the file: their products are checked before anything is allocated.
    if (array.chunks[a] < 1 || __builtin_mul_overflow(voxels, array.shape[a], &voxels) ||
        voxels > kMostVolumeVoxels || __builtin_mul_overflow(chunk, array.chunks[a], &chunk) ||
        static_cast<uint64_t>(chunk) > kMostChunkBytes / bytesPerVoxel(array.type))
      fail("{}: expected at most {} voxels in chunks of at most {} bytes, found more", name,
           kMostVolumeVoxels, kMostChunkBytes);
  }
  return array;
}

std::unique_ptr<ChunkedArray> hdf5Chunks(const Hdf5Input& input, std::unique_ptr<Hdf5Set> set,
                                         ZarrArray array, const std::string& name) {
  return std::make_unique<Hdf5Array>(input.file, std::move(set), name, std::move(array));
}

}  // namespace sluice

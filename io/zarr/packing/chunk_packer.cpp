#include "io/zarr/packing/chunk_packer.h"

#include <bit>
#include <cstring>
#include <type_traits>
#include <utility>

namespace sluice {
namespace {

// Whether a row of voxels is one voxel, which `word` repeats.
bool isFill(const std::byte* row, size_t bytes, uint64_t word) {
  uint64_t difference = 0;
  size_t at = 0;
  for (; at + sizeof word <= bytes; at += sizeof word) {
    uint64_t found = 0;
    std::memcpy(&found, row + at, sizeof found);
    difference |= found ^ word;
  }
  if (difference != 0) return false;
  // Most rows are whole words: a call for nothing would take as long as the row.
  return at == bytes || std::memcmp(row + at, &word, bytes - at) == 0;
}

// Whether all voxels of a box are fill value. Most boxes that are not tell so in their first rows.
bool isFillIn(const Box3& box, const HeldVoxels& held, std::span<const std::byte> fill) {
  const auto voxel = static_cast<int64_t>(fill.size());
  const auto row_bytes = static_cast<size_t>(box.size().x * voxel);
  const Vec3i lo = held.box.lo, size = held.box.size();
  uint64_t word = 0;
  for (size_t at = 0; at < sizeof word; at += fill.size())
    std::memcpy(reinterpret_cast<std::byte*>(&word) + at, fill.data(), fill.size());
  for (int64_t z = box.lo.z; z < box.hi.z; ++z)
    for (int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const int64_t at = ((z - lo.z) * size.y + y - lo.y) * size.x + box.lo.x - lo.x;
      if (!isFill(held.voxels + at * voxel, row_bytes, word)) return false;
    }
  return true;
}

}  // namespace

ZarrArray packedArray(const VolumeLayout& layout, std::span<const int64_t> leading,
                      int64_t chunk_voxels, double fill_value) {
  ZarrArray array;
  for (const int64_t count : leading) {
    array.shape.push_back(count);
    array.chunks.push_back(1);
  }
  for (int a = 2; a >= 0; --a) {
    array.shape.push_back(layout.dims[a]);
    array.chunks.push_back(chunk_voxels);
  }
  array.files = array.chunks;
  array.type = layout.type;
  array.byte_order = std::endian::native;
  array.codec = ZarrCodec::kBlosc;
  array.separator = '/';
  array.fill_value = fill_value;
  return array;
}

std::vector<std::byte> fillVoxel(const ZarrArray& array) {
  std::vector<std::byte> fill(bytesPerVoxel(array.type));
  visitVoxelType(array.type, [&](auto tag) {
    tag = static_cast<decltype(tag)>(array.fill_value);
    std::memcpy(fill.data(), &tag, sizeof tag);
  });
  return fill;
}

ChunkPacker::ChunkPacker(std::span<const PackedArray> arrays, int64_t chunk_voxels,
                         const BloscOptions& blosc)
    : arrays_(arrays), chunk_voxels_(chunk_voxels), blosc_(blosc) {
  for (const PackedArray& packed : arrays) fills_.push_back(fillVoxel(packed.array));
}

std::vector<Vec3i> ChunkPacker::chunksOf(const Box3& box) const {
  const int64_t side = chunk_voxels_;
  std::vector<Vec3i> chunks;
  for (int64_t z = box.lo.z / side; z * side < box.hi.z; ++z)
    for (int64_t y = box.lo.y / side; y * side < box.hi.y; ++y)
      for (int64_t x = box.lo.x / side; x * side < box.hi.x; ++x) chunks.push_back({x, y, z});
  return chunks;
}

Box3 ChunkPacker::boxOf(Vec3i chunk) const {
  const int64_t side = chunk_voxels_;
  return {chunk * side, chunk * side + Vec3i{side, side, side}};
}

int64_t ChunkPacker::numberOf(const ZarrPackFolder& folder, size_t array,
                              std::span<const int64_t> leading, Vec3i chunk) const {
  std::vector<int64_t> index(leading.begin(), leading.end());
  for (int a = 2; a >= 0; --a) index.push_back(chunk[a]);
  return folder.firstChunk(array) + arrays_[array].array.chunkNumber(index);
}

void ChunkPacker::pack(ZarrPackFolder& folder, size_t array, int64_t number, const HeldVoxels& held,
                       Vec3i chunk) {
  const Lease scratch(*this);
  const std::vector<std::byte>& fill = fills_[array];
  const auto voxel = static_cast<int64_t>(fill.size());
  const Box3 whole = boxOf(chunk), box = intersect(whole, held.box);
  if (isFillIn(box, held, fill)) return folder.write(number, {}, scratch->number);
  const std::span bytes = std::span(scratch->chunk).first(arrays_[array].array.chunkBytes());
  if (box != whole)
    for (size_t i = 0; i < bytes.size(); i += fill.size())
      std::memcpy(bytes.data() + i, fill.data(), fill.size());
  const int64_t side = chunk_voxels_;
  const Vec3i lo = held.box.lo, size = held.box.size();
  const auto copyRows = [&](auto row_bytes) {
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y) {
        const int64_t from = ((z - lo.z) * size.y + y - lo.y) * size.x + box.lo.x - lo.x;
        const int64_t to = ((z - whole.lo.z) * side + y - whole.lo.y) * side;
        std::memcpy(bytes.data() + to * voxel, held.voxels + from * voxel, row_bytes);
      }
  };
  // Millions of rows are as short as this: a call for each takes longer than the copying.
  constexpr size_t kUsualBytes = 64;
  const auto row_bytes = static_cast<size_t>(box.size().x * voxel);
  if (row_bytes == kUsualBytes)
    copyRows(std::integral_constant<size_t, kUsualBytes>());
  else
    copyRows(row_bytes);
  folder.write(number, encodeBlosc(bytes, fill.size(), blosc_, scratch->stored), scratch->number);
}

void ChunkPacker::packEmpty(ZarrPackFolder& folder, int64_t number) {
  folder.write(number, {}, Lease(*this)->number);
}

ChunkPacker::Lease::Lease(ChunkPacker& packer) : packer_(packer) {
  const MutexLock lock(packer.mutex_);
  if (packer.idle_.empty()) {
    scratch_ = std::make_unique<Scratch>();
    scratch_->number = packer.made_++;
    scratch_->chunk.resize(packer.arrays_.front().array.chunkBytes());
  } else {
    scratch_ = std::move(packer.idle_.back());
    packer.idle_.pop_back();
  }
}

ChunkPacker::Lease::~Lease() {
  const MutexLock lock(packer_.mutex_);
  packer_.idle_.push_back(std::move(scratch_));
}

}  // namespace sluice

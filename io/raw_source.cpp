#include "io/raw_source.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// Reading across a gap of a page costs less than another system call, and a disk reads it anyway.
constexpr uint64_t kMaxGapBytes = 4096;

// Collects pieces of one store into vectored reads.
class Gather {
 public:
  // `to` is filled with `bytes` bytes from `offset` of `store`. Offsets rise within a store.
  void add(ByteStore& store, uint64_t offset, std::byte* to, uint64_t bytes) {
    const bool near = store_ == &store && count_ + 2 <= parts_.size() && offset >= end_ &&
                      offset - end_ <= kMaxGapBytes;
    if (!near) {
      flush();
      store_ = &store;
      begin_ = end_ = offset;
    }
    if (offset > end_) parts_[count_++] = {gap_.data(), offset - end_};
    const bool adjoins =
        count_ > 0 && offset == end_ &&
        static_cast<std::byte*>(parts_[count_ - 1].iov_base) + parts_[count_ - 1].iov_len == to;
    if (adjoins)
      parts_[count_ - 1].iov_len += bytes;
    else
      parts_[count_++] = {to, bytes};
    end_ = offset + bytes;
  }

  void flush() {
    if (count_ > 0) store_->read(begin_, std::span(parts_).first(count_));
    count_ = 0;
  }

 private:
  ByteStore* store_ = nullptr;
  uint64_t begin_ = 0, end_ = 0;  // of the pieces collected, in the store
  size_t count_ = 0;
  std::array<iovec, ByteStore::kMaxParts> parts_;
  std::array<std::byte, kMaxGapBytes> gap_;
};

template <class Word>
void swapWords(std::span<std::byte> bytes) {
  for (size_t i = 0; i + sizeof(Word) <= bytes.size(); i += sizeof(Word)) {
    Word word;
    std::memcpy(&word, bytes.data() + i, sizeof(Word));
    if constexpr (sizeof(Word) == 2) word = __builtin_bswap16(word);
    if constexpr (sizeof(Word) == 4) word = __builtin_bswap32(word);
    if constexpr (sizeof(Word) == 8) word = __builtin_bswap64(word);
    std::memcpy(bytes.data() + i, &word, sizeof(Word));
  }
}

void swapBytes(std::span<std::byte> bytes, size_t voxel_bytes) {
  if (voxel_bytes == 2) swapWords<uint16_t>(bytes);
  if (voxel_bytes == 4) swapWords<uint32_t>(bytes);
  if (voxel_bytes == 8) swapWords<uint64_t>(bytes);
}

}  // namespace

RawSource::RawSource(VolumeLayout layout, std::endian byte_order, std::vector<RawSegment> segments,
                     std::shared_ptr<const ByteStore> header, std::string identity)
    : layout_(std::move(layout)),
      swapped_(byte_order != std::endian::native),
      segments_(std::move(segments)),
      segment_voxels_(volume(layout_.dims) * layout_.time_steps /
                      static_cast<int64_t>(segments_.size())),
      header_(std::move(header)),
      identity_(std::move(identity)) {
  SLUICE_CHECK_EQ(segment_voxels_ * static_cast<int64_t>(segments_.size()),
                  volume(layout_.dims) * layout_.time_steps);
}

uint64_t RawSource::storedBytesRead() const {
  uint64_t sum = header_ == nullptr ? 0 : header_->storedBytesRead();
  for (const RawSegment& segment : segments_) sum += segment.store->storedBytesRead();
  return sum;
}

void RawSource::readRegion(int64_t time, const Box3& box, std::span<std::byte> out) {
  const Vec3i dims = layout_.dims;
  const int64_t voxel_bytes = static_cast<int64_t>(bytesPerVoxel(layout_.type));
  SLUICE_CHECK(!box.empty() && boxOf(dims).contains(box));
  SLUICE_CHECK(time >= 0 && time < layout_.time_steps);
  SLUICE_CHECK_EQ(static_cast<int64_t>(out.size()), box.count() * voxel_bytes);

  // Whole rows that follow one another are one piece, and so are whole planes.
  Vec3i pieces = box.size();
  int64_t piece_voxels = std::exchange(pieces.x, 1);
  if (box.size().x == dims.x) {
    piece_voxels *= std::exchange(pieces.y, 1);
    if (box.size().y == dims.y) piece_voxels *= std::exchange(pieces.z, 1);
  }
  Gather gather;
  std::byte* to = out.data();
  for (int64_t z = box.lo.z; z < box.lo.z + pieces.z; ++z)
    for (int64_t y = box.lo.y; y < box.lo.y + pieces.y; ++y) {
      int64_t voxel = ((time * dims.z + z) * dims.y + y) * dims.x + box.lo.x;
      for (int64_t left = piece_voxels; left > 0;) {
        const RawSegment& segment = segments_[static_cast<size_t>(voxel / segment_voxels_)];
        const int64_t inside = voxel % segment_voxels_;
        const int64_t taken = std::min(left, segment_voxels_ - inside);
        const auto bytes = static_cast<uint64_t>(taken * voxel_bytes);
        gather.add(*segment.store,
                   segment.offset_bytes + static_cast<uint64_t>(inside * voxel_bytes), to, bytes);
        to += bytes;
        voxel += taken;
        left -= taken;
      }
    }
  gather.flush();
  if (swapped_) swapBytes(out, static_cast<size_t>(voxel_bytes));
}

}  // namespace sluice

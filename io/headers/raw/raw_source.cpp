#include "io/headers/raw/raw_source.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "io/files/swap_bytes.h"
#include "src/base/error.h"
#include "src/base/memory/aligned_array.h"
#include "src/base/sources/region_check.h"

namespace sluice {
namespace {

// A gap smaller than a page saves the disk nothing when it is left out. A gap is read across if the
// pieces around it are so small that a system call for each would cost more than the copying, or if
// it adds at most a quarter to the wanted bytes.
constexpr uint64_t kMaxGapBytes = 4096;
constexpr uint64_t kSmallPieceBytes = 256;
constexpr uint64_t kWantedBytesPerGapByte = 4;

// A disk is told beforehand of pieces of planes from this size on, if all their pages are wanted.
constexpr uint64_t kLeastExpectedBytes = 32 << 10;

bool readsAcross(uint64_t gap_bytes, uint64_t piece_bytes) {
  if (gap_bytes > kMaxGapBytes) return false;
  return piece_bytes < kSmallPieceBytes || gap_bytes <= piece_bytes / kWantedBytesPerGapByte;
}

bool sameRows(std::span<const RegionRead> regions) {
  const Box3& first = regions.front().box;
  return std::all_of(regions.begin(), regions.end(), [&](const RegionRead& region) {
    const Box3& box = region.box;
    return box.lo.y == first.lo.y && box.hi.y == first.hi.y && box.lo.z == first.lo.z &&
           box.hi.z == first.hi.z;
  });
}

}  // namespace

// Collects pieces of a store, in the order of their offsets, into large reads. Pieces may overlap.
// A single system call fetches neighbouring pieces, which are then copied out of it: the kernel
// takes longer to hand out 64 bytes than a copy does.
class RawSource::Gather {
 public:
  explicit Gather(RawSource& source) : source_(source) {}
  ~Gather() {
    if (span_ == nullptr) return;
    const MutexLock lock(source_.spans_mutex_);
    source_.idle_spans_.push_back(std::move(span_));
  }
  Gather(const Gather&) = delete;
  Gather& operator=(const Gather&) = delete;

  // `to` is filled with `bytes` bytes from `offset` of `store`.
  void add(ByteStore& store, uint64_t offset, std::byte* to, uint64_t bytes) {
    if (!pieces_.empty() && store_ == &store) {
      Piece& last = pieces_.back();
      // Adjacent in the file and in memory: read straight into its place.
      if (offset == end_ && last.to + last.bytes == to && pieces_.size() == 1) {
        last.bytes += bytes;
        end_ += bytes;
        return;
      }
      const uint64_t end = std::max(end_, offset + bytes);
      const bool is_near = offset <= end_ || readsAcross(offset - end_, end_ - run_begin_);
      if (offset >= last.offset && is_near && end - pieces_.front().offset <= kSpanBytes) {
        if (offset > end_) run_begin_ = offset;
        pieces_.push_back({offset, to, bytes});
        end_ = end;
        return;
      }
    }
    // Too far away, of another file, or before the last one.
    flush();
    store_ = &store;
    pieces_.push_back({offset, to, bytes});
    run_begin_ = offset;
    end_ = offset + bytes;
  }

  void flush() {
    if (pieces_.size() == 1) {
      read(pieces_.front().offset, {pieces_.front().to, pieces_.front().bytes});
    } else if (!pieces_.empty()) {
      if (span_ == nullptr) span_ = takeSpan();
      const uint64_t begin = pieces_.front().offset;
      read(begin, {span_.get(), end_ - begin});
      for (const Piece& piece : pieces_)
        std::memcpy(piece.to, span_.get() + (piece.offset - begin), piece.bytes);
    }
    pieces_.clear();
  }

 private:
  struct Piece {
    uint64_t offset;
    std::byte* to;
    uint64_t bytes;
  };
  static constexpr uint64_t kSpanBytes = 256 << 10;

  AlignedArray<std::byte> takeSpan() {
    const MutexLock lock(source_.spans_mutex_);
    if (source_.idle_spans_.empty()) return alignedForOverwrite<std::byte>(kSpanBytes);
    AlignedArray<std::byte> span = std::move(source_.idle_spans_.back());
    source_.idle_spans_.pop_back();
    return span;
  }
  void read(uint64_t offset, std::span<std::byte> to) {
    const iovec part{to.data(), to.size()};
    store_->read(offset, std::span(&part, 1));
  }

  RawSource& source_;
  ByteStore* store_ = nullptr;
  std::vector<Piece> pieces_;
  uint64_t end_ = 0;        // end of the pieces in the store
  uint64_t run_begin_ = 0;  // begin of the bytes that lie before end_ without a gap
  AlignedArray<std::byte> span_;
};

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

void RawSource::addPiece(Gather& gather, int64_t first, int64_t voxels, std::byte* to) const {
  const auto voxel_bytes = static_cast<int64_t>(bytesPerVoxel(layout_.type));
  while (voxels > 0) {
    const RawSegment& segment = segments_[static_cast<size_t>(first / segment_voxels_)];
    const int64_t inside = first % segment_voxels_;
    const int64_t taken = std::min(voxels, segment_voxels_ - inside);
    const auto bytes = static_cast<uint64_t>(taken * voxel_bytes);
    gather.add(*segment.store, segment.offset_bytes + static_cast<uint64_t>(inside * voxel_bytes),
               to, bytes);
    to += bytes;
    first += taken;
    voxels -= taken;
  }
}

bool RawSource::isExpected(const Box3& box) const {
  const uint64_t voxel_bytes = bytesPerVoxel(layout_.type);
  const auto left_out = static_cast<uint64_t>(layout_.dims.x - box.size().x);
  return left_out * voxel_bytes < kMaxGapBytes &&
         static_cast<uint64_t>(box.size().y * layout_.dims.x) * voxel_bytes >= kLeastExpectedBytes;
}

void RawSource::expectRegion(int64_t time, const Box3& box) {
  if (isExpected(box)) expectPlanes(time, box);
}

void RawSource::expectPlanes(int64_t time, const Box3& box) const {
  const Vec3i dims = layout_.dims;
  const auto voxel_bytes = static_cast<int64_t>(bytesPerVoxel(layout_.type));
  for (int64_t z = box.lo.z; z < box.hi.z; ++z) {
    const int64_t first = ((time * dims.z + z) * dims.y + box.lo.y) * dims.x;
    const RawSegment& segment = segments_[static_cast<size_t>(first / segment_voxels_)];
    const int64_t inside = first % segment_voxels_ * voxel_bytes;
    segment.store->expectRead(segment.offset_bytes + static_cast<uint64_t>(inside),
                              static_cast<uint64_t>(box.size().y * dims.x * voxel_bytes));
  }
}

std::vector<std::string> RawSource::files() {
  std::vector<std::string> all;
  if (header_ != nullptr) all = header_->paths();
  for (const RawSegment& segment : segments_)
    for (std::string& path : segment.store->paths()) all.push_back(std::move(path));
  return all;
}

ReadUnits RawSource::readUnits() const {
  const ByteStore& store = *segments_.front().store;
  const auto unit = static_cast<int64_t>(store.unitBytes() / bytesPerVoxel(layout_.type));
  const Vec3i rows{layout_.dims.x, std::clamp<int64_t>(unit / layout_.dims.x, 1, layout_.dims.y),
                   1};
  return {.voxels = unit > 1 ? rows : Vec3i{1, 1, 1}, .is_one_stream = store.isOneStream()};
}

uint64_t RawSource::heldBytesAThread() const {
  uint64_t bytes = 0;
  for (const RawSegment& segment : segments_)
    bytes = std::max(bytes, segment.store->heldBytesAThread());
  return bytes;
}

void RawSource::holdAtMost(uint64_t bytes) {
  for (const RawSegment& segment : segments_) segment.store->holdAtMost(bytes / segments_.size());
}

void RawSource::readRegion(int64_t time, const Box3& box, std::span<std::byte> out) {
  const RegionRead region{box, out};
  readRegions(time, std::span(&region, 1));
}

void RawSource::readRegions(int64_t time, std::span<const RegionRead> regions) {
  if (regions.empty()) return;
  // Regions side by side in the same rows are read in one go, each row of the file once.
  if (regions.size() > 1 && !sameRows(regions)) {
    for (size_t from = 0, to = 0; from < regions.size(); from = to) {
      while (to < regions.size() && sameRows(regions.subspan(from, to - from + 1))) ++to;
      readRegions(time, regions.subspan(from, to - from));
    }
    return;
  }
  const Vec3i dims = layout_.dims;
  const auto voxel_bytes = static_cast<int64_t>(bytesPerVoxel(layout_.type));
  for (const auto& [box, out] : regions) checkRegion(layout_, time, box, out);
  std::vector<RegionRead> sorted(regions.begin(), regions.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const RegionRead& a, const RegionRead& b) { return a.box.lo.x < b.box.lo.x; });

  // Whole rows that follow one another are one piece, and so are whole planes.
  const Box3& rows = sorted.front().box;
  Vec3i pieces = rows.size();
  int64_t rows_a_piece = 1;
  if (sorted.size() == 1 && rows.size().x == dims.x) {
    rows_a_piece = std::exchange(pieces.y, 1);
    if (rows.size().y == dims.y) rows_a_piece *= std::exchange(pieces.z, 1);
  }
  const Box3 all = unite(rows, sorted.back().box);
  if (pieces.z > 1 && isExpected(all)) expectPlanes(time, all);
  Gather gather(*this);
  for (int64_t z = 0; z < pieces.z; ++z)
    for (int64_t y = 0; y < pieces.y; ++y)
      for (const auto& [box, out] : sorted) {
        const Vec3i size = box.size();
        addPiece(gather,
                 ((time * dims.z + box.lo.z + z) * dims.y + box.lo.y + y) * dims.x + box.lo.x,
                 size.x * rows_a_piece, out.data() + (z * size.y + y) * size.x * voxel_bytes);
      }
  gather.flush();
  if (swapped_)
    for (const RegionRead& region : sorted) swapBytes(region.out, static_cast<size_t>(voxel_bytes));
}

}  // namespace sluice

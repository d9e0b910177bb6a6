#include "src/index/box_store.h"

#include <fmt/format.h>

#include <algorithm>

#include "src/index/index_file.h"

namespace sluice {
namespace {

// A key for each piece: a frame that sees a corner of the volume reads that corner's boxes.
IndexKey keyOf(const VolumeSource& source, int64_t time, const BlockLayout& layout, int64_t first) {
  return {source.identity(),
          fmt::format("boxes-{}{}-{}-from{}", layout.size, layout.ghost == 0 ? "" : "-lit",
                      selectionOf(source.layout(), time), first),
          kBoxesVersion};
}

BoxesOrigin originOf(const SliceRanges& ranges) {
  return {ranges.layout, ranges.map, growingParameters(ranges.map.type, ranges.device_range),
          kGrowingBrickSide};
}

struct PieceSpan {
  int64_t first = 0, count = 0;     // blocks
  std::span<const int64_t> blocks;  // blocks of the run that are not background
};
PieceSpan pieceSpan(const SliceRanges& ranges, int64_t block) {
  PieceSpan piece;
  piece.first = block / BoxStore::kPieceBlocks * BoxStore::kPieceBlocks;
  piece.count = std::min(BoxStore::kPieceBlocks, ranges.layout.blockCount() - piece.first);
  // The blocks ascend, and a piece is a run of ids: its blocks lie together in the list.
  const auto begin = std::lower_bound(ranges.blocks.begin(), ranges.blocks.end(), piece.first);
  const auto end = std::lower_bound(begin, ranges.blocks.end(), piece.first + piece.count);
  piece.blocks = {begin, end};
  return piece;
}

BoxesPiece assemble(int64_t first, const std::vector<std::vector<std::byte>>& trees) {
  BoxesPiece piece;
  piece.first = first;
  for (const std::vector<std::byte>& tree : trees) {
    piece.bytes.insert(piece.bytes.end(), tree.begin(), tree.end());
    piece.ends.push_back(piece.bytes.size());
  }
  return piece;
}

}  // namespace

BoxStore::BoxStore(VolumeSource& source, IndexPlaces places, int64_t time,
                   const SliceRanges& ranges, WorkerPool& pool, uint64_t budget_bytes,
                   uint64_t growing_bytes, ReadFor read)
    : source_(source),
      places_(std::move(places)),
      time_(time),
      ranges_(ranges),
      pool_(pool),
      budget_bytes_(budget_bytes),
      growing_bytes_(growing_bytes),
      read_(std::move(read)),
      origin_(originOf(ranges)),
      trees_(budget_bytes, Held::kMayLeave) {}

BoxStoreCounters BoxStore::counters() const {
  const CacheCounters trees = trees_.counters();
  const MutexLock lock(mutex_);
  BoxStoreCounters counters;
  counters.requests = static_cast<int64_t>(trees.requests) + background_requests_;
  counters.hits = static_cast<int64_t>(trees.hits + trees.coalesced);
  counters.pieces_read = pieces_read_;
  counters.pieces_built = pieces_built_;
  counters.current_bytes = trees.current_bytes;
  counters.peak_bytes = trees.peak_bytes;
  return counters;
}

BoxTreePtr BoxStore::tree(int64_t block, const ReadPurpose& purpose) {
  return treeOf(block, true, purpose);
}

BoxTreePtr BoxStore::treeIfMade(int64_t block) {
  return treeOf(block, false, {});
}

BoxTreePtr BoxStore::treeOf(int64_t block, bool may_build, const ReadPurpose& purpose) {
  SLUICE_CHECK(block >= 0 && block < origin_.layout.blockCount());
  // The index holds no trees of background blocks.
  if (!std::binary_search(ranges_.blocks.begin(), ranges_.blocks.end(), block)) {
    const MutexLock lock(mutex_);
    ++background_requests_;
    return backgroundTree(block);
  }
  for (;;) {
    BoxTreePtr tree = trees_.get(block, 0, [&] {
      BoxTreePtr made = decode(block, may_build, purpose);
      const uint64_t bytes = made == nullptr ? 0 : made->bytes();
      // A tree that is not kept goes to the threads that wait for it now.
      const bool keep = made != nullptr && bytes <= budget_bytes_;
      return Trees::Loaded{std::move(made), bytes, keep};
    });
    // A lookup in the index alone that found nothing, by another thread, still allows building.
    if (tree != nullptr || !may_build) return tree;
  }
}

BoxTreePtr BoxStore::decode(int64_t block, bool may_build, const ReadPurpose& purpose) {
  // Held while the piece is read or built: the header promises one at a time.
  const MutexLock lock(mutex_);
  const Vec3i cells = origin_.layout.ownedCells(origin_.layout.indexOf(block)).size();
  const BoxesPiece* piece = pieceOf(block, may_build, purpose);
  if (piece == nullptr) return nullptr;
  std::optional<BoxTree> decoded = deserializeBoxTree(piece->treeBytes(block), cells);
  if (!decoded) {
    if (!may_build) return nullptr;
    // The index is intact and yet not ours: someone else's bytes under our key. Made anew.
    const int64_t first = piece_->first, count = static_cast<int64_t>(piece_->ends.size());
    piece_.reset();
    piece_ = buildPiece(first, count, purpose);
    ++pieces_built_;
    decoded = deserializeBoxTree(piece_->treeBytes(block), cells);
    SLUICE_CHECK(decoded.has_value());
  }
  return std::make_shared<const BoxTree>(std::move(*decoded));
}

const BoxesPiece* BoxStore::pieceOf(int64_t block, bool may_build, const ReadPurpose& purpose) {
  const auto [first, count, blocks] = pieceSpan(ranges_, block);
  if (piece_ && piece_->first == first) return &*piece_;
  // The old piece goes before the new one is read, so that one is in memory at a time.
  piece_.reset();
  piece_ = readPiece(first, count);
  if (piece_) {
    ++pieces_read_;
    return &*piece_;
  }
  if (!may_build) return nullptr;
  piece_ = buildPiece(first, count, purpose);
  ++pieces_built_;
  return &*piece_;
}

std::optional<BoxesPiece> BoxStore::readPiece(int64_t first, int64_t count) const {
  const IndexRead kept = readIndex(places_, keyOf(source_, time_, origin_.layout, first));
  if (!kept.blob) return std::nullopt;
  return deserializeBoxesPiece(*kept.blob, origin_, first, count);
}

BoxesPiece BoxStore::buildPiece(int64_t first, int64_t count, const ReadPurpose& purpose) const {
  std::vector<std::vector<std::byte>> trees(static_cast<size_t>(count));
  ProgressMeter progress;
  const auto grow = [&](int64_t block, const BrickGrid& grid) {
    // Voxels that contradict the ranges mean that the file has changed: no index is made of them.
    expectSameValues(source_, time_, ranges_, block, grid);
    trees[static_cast<size_t>(block - first)] = serialize(growBoxTree(grid, origin_.parameters));
  };
  ReadVoxels read;
  // Voxels go through the caller's levels, which count them.
  if (read_) read = [&](int64_t time, const RegionRead& region) { read_(time, region, purpose); };
  forEachBlockBricks(source_, time_, origin_.layout, pieceSpan(ranges_, first).blocks,
                     {pool_, progress, growing_bytes_, purpose.stop}, grow, read);
  BoxesPiece piece = assemble(first, trees);
  // An index is a convenience: if it cannot be kept, the next opening makes it again.
  writeIndex(places_, keyOf(source_, time_, origin_.layout, first), serialize(piece, origin_));
  return piece;
}

BoxTreePtr BoxStore::backgroundTree(int64_t block) const {
  const Vec3i cells = origin_.layout.ownedCells(origin_.layout.indexOf(block)).size();
  const auto value = static_cast<float>(ranges_.background);
  BoxTree tree;
  GrownBox box;
  for (int a = 0; a < 3; ++a) box.hi[static_cast<size_t>(a)] = static_cast<uint16_t>(cells[a]);
  box.range = {value, value, 0, kLargest};
  box.type = BoxType::kUniform;
  tree.boxes = tree.textures = {box};
  tree.texture_of = {0};
  tree.grown = 1;
  TreeNode leaf;
  leaf.box = 0;
  tree.nodes = {leaf};
  return std::make_shared<const BoxTree>(std::move(tree));
}

BoxIndexWriter::BoxIndexWriter(const VolumeSource& source, IndexPlaces places, int64_t time,
                               const SliceRanges& ranges)
    : source_(source),
      places_(std::move(places)),
      time_(time),
      ranges_(ranges),
      origin_(originOf(ranges)) {}

void BoxIndexWriter::add(int64_t block, const BoxTree& tree) {
  std::vector<std::byte> bytes = serialize(tree);
  const auto [first, count, blocks] = pieceSpan(ranges_, block);
  Pending whole;
  // Only the last of a piece's blocks writes it, outside the lock.
  {
    const MutexLock lock(mutex_);
    Pending& pending = pending_[first];
    if (pending.trees.empty()) {
      pending.trees.resize(static_cast<size_t>(count));
      // Background blocks are never added: their trees stay empty.
      pending.missing = static_cast<int64_t>(blocks.size());
    }
    pending.trees[static_cast<size_t>(block - first)] = std::move(bytes);
    if (--pending.missing > 0) return;
    whole = std::move(pending);
    pending_.erase(first);
  }
  const IndexWritten written = writeIndex(places_, keyOf(source_, time_, origin_.layout, first),
                                          serialize(assemble(first, whole.trees), origin_));
  const MutexLock lock(mutex_);
  pieces_written_ += written.path.empty() ? 0 : 1;
}

int64_t BoxIndexWriter::piecesWritten() const {
  const MutexLock lock(mutex_);
  return pieces_written_;
}

}  // namespace sluice

#include "src/render/session.h"

#include <algorithm>

#include "src/base/bytes.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// Plans differ when one of these does.
bool samePlan(const FrameOptions& a, const FrameOptions& b) {
  return a.algorithm == b.algorithm && a.merge_order == b.merge_order;
}
// What is drawn of growing boxes follows from these too.
bool sameBoxCost(const FrameOptions& a, const FrameOptions& b) {
  return a.step_vox == b.step_vox;
}
// Modes other than composite look at values alone.
bool looksAtGradients(const FrameOptions& options) {
  return options.mode == Mode::kComposite;
}
bool sameCrop(const FrameOptions& a, const FrameOptions& b) {
  return a.crop == b.crop;
}

}  // namespace

namespace {

// Enough to keep a disk busy that serves many reads at once, on machines of few cores too.
constexpr int kReadsInFlight = 4;

// Growing boxes get one part in so many of the memory beyond the least, and the voxels that they
// are made of another. Half of the first is for trees of all boxes, half for the boxes that frames
// draw.
constexpr uint64_t kBoxShare = 8;

// The largest chunk: two whole blocks side by side, in whole pages.
uint64_t largestChunkBytes(const PageGeometry& page, int64_t block_vox) {
  return static_cast<uint64_t>(page.pagesOf(Vec3i{2 * block_vox, block_vox, block_vox}) *
                               page.pageBytes());
}

// What a thread that reads has under way.
uint64_t threadBytes(const PageGeometry& page, const BufferNeeds& needs) {
  const int64_t side = needs.block_vox;
  const auto block_bytes =
      static_cast<uint64_t>(volume(Vec3i{side, side, side}) * page.bytes_per_voxel);
  return 2 * block_bytes + VolumeBuffer::kScratchBytes + needs.source_thread_bytes +
         needs.growing_bytes;
}

}  // namespace

BufferNeeds bufferNeeds(const VolumeSource& source, const BlockLayout& layout,
                        Partition partition) {
  BufferNeeds needs{layout.size, source.heldBytesAThread()};
  if (partition == Partition::kBoxes) needs.growing_bytes = growingBytes(source.layout(), layout);
  return needs;
}

uint64_t leastBufferBytes(const PageGeometry& page, const BufferNeeds& needs) {
  return 2 * largestChunkBytes(page, needs.block_vox) + 2 * threadBytes(page, needs);
}

uint64_t textureMemoryBytes(const PageGeometry& page, bool textures_in_memory) {
  const auto cache_bytes = static_cast<uint64_t>(page.cacheBytes());
  return textures_in_memory ? cache_bytes + spareTextureBytes(cache_bytes) : 0;
}

Budgets shareMemory(uint64_t memory_bytes, const PageGeometry& page, bool textures_in_memory,
                    const BufferNeeds& needs, int most_readers) {
  Budgets budgets;
  budgets.texture_cache = static_cast<uint64_t>(page.cacheBytes());
  const uint64_t least_buffers = leastBufferBytes(page, needs);
  const uint64_t textures = textureMemoryBytes(page, textures_in_memory);
  if (memory_bytes < textures + least_buffers)
    fail(
        "--memory {} is too small: {} of textures and {} of buffers are the least that works; "
        "give --memory {} or fewer --pages",
        formatBytes(memory_bytes), formatBytes(textures), formatBytes(least_buffers),
        textures + least_buffers);
  // Beyond the least: an eighth for growing boxes, one for what they are made of and one for a
  // source where these can use it, a third of what is left for chunks, the rest for blocks and for
  // more readers.
  uint64_t surplus = memory_bytes - textures - least_buffers;
  if (needs.growing_bytes > 0) {
    budgets.boxes = surplus / kBoxShare;
    budgets.growing = std::min(surplus / kBoxShare, kMostGrowingBytes);
  }
  surplus -= budgets.boxes + budgets.growing;
  budgets.texture_buffer = 2 * largestChunkBytes(page, needs.block_vox) + surplus / 3;
  const uint64_t source_surplus = needs.source_thread_bytes > 0 ? surplus / 8 : 0;
  const uint64_t rest = memory_bytes - textures - budgets.texture_buffer - source_surplus -
                        budgets.boxes - budgets.growing;
  const auto most_threads = static_cast<uint64_t>(most_readers) + 1;
  const uint64_t threads = std::min(most_threads, rest / threadBytes(page, needs));
  budgets.readers = static_cast<int>(threads) - 1;
  budgets.scratch = threads * VolumeBuffer::kScratchBytes;
  budgets.source = threads * needs.source_thread_bytes + source_surplus;
  budgets.growing += threads * needs.growing_bytes;
  budgets.volume_buffer =
      rest - budgets.scratch - threads * (needs.source_thread_bytes + needs.growing_bytes);
  return budgets;
}

Session::Session(VolumeSource& source, int64_t time, const SliceRanges& ranges, Device& device,
                 WorkerPool& pool, const SessionOptions& options)
    : source_(source),
      time_(time),
      ranges_(ranges),
      device_(device),
      pool_(pool),
      options_(options),
      budgets_(shareMemory(options.memory_bytes, options.page, device.limits().textures_in_memory,
                           bufferNeeds(source, ranges.layout, options.partition),
                           std::max(pool.threads(), kReadsInFlight))),
      blocks_(source, ranges.layout, budgets_.volume_buffer, VolumeBuffer::Cold::kPacked),
      readers_(budgets_.readers + 1),
      chunks_(blocks_, readers_, budgets_.texture_buffer),
      cache_(static_cast<uint64_t>(options.page.pages),
             static_cast<uint64_t>(options.page.pageBytes()),
             makePolicy(options.policy, static_cast<uint64_t>(options.page.pages), options.seed)),
      first_id_(device.takeIdRange()) {
  SLUICE_CHECK_EQ(options.page.bytes_per_voxel,
                  static_cast<int64_t>(bytesPerVoxel(ranges.map.type)));
  SLUICE_CHECK(!options.lit || ranges.layout.ghost == 1);
  source_.holdAtMost(budgets_.source);
  if (options.partition == Partition::kBoxes)
    box_store_.emplace(source, options.volume_name, time, ranges, readers_, budgets_.boxes / 2,
                       budgets_.growing);
}

Session::~Session() {
  // The device outlives us: leave it without our chunks.
  for (uint64_t id = first_id_; id < first_id_ + chunk_names_.count(); ++id)
    if (cache_.contains(id)) device_.evict(id);
}

void Session::setTransferFunction(const TransferFunction& transfer) {
  SLUICE_CHECK(transfer.gradients.empty() || ranges_.layout.ghost == 1);
  transfer_ = transfer;
  table_.reset();
  classification_.reset();
  dropPlan();
}

void Session::setOptions(const FrameOptions& options) {
  if (!sameCrop(options, frame_options_)) classification_.reset();
  if (!samePlan(options, frame_options_)) dropPlan();
  if (!sameBoxCost(options, frame_options_)) dropDrawnBoxes();
  if (looksAtGradients(options) != looksAtGradients(frame_options_)) {
    table_.reset();
    dropDrawnBoxes();
  }
  if (options.occlusion != frame_options_.occlusion) {
    last_shown_.clear();
    update_count_ = UpdateCount(kUpdates);
  }
  frame_options_ = options;
}

void Session::dropPlan() {
  last_shown_.clear();
  ahead_.reset();  // what it still reads is no longer wanted
  plan_.reset();
  dropDrawnBoxes();
}

void Session::dropDrawnBoxes() {
  drawn_boxes_.clear();
  drawn_boxes_bytes_ = 0;
}

std::shared_ptr<const DrawnBoxes> Session::drawnBoxes(int64_t position) {
  if (const auto found = drawn_boxes_.find(position); found != drawn_boxes_.end())
    return found->second;
  const TextureBlock& block = plan_->blocks[static_cast<size_t>(position)];
  SLUICE_CHECK(box_store_.has_value());
  const BoxTreePtr tree = frame_options_.time_limit_s ? box_store_->treeIfMade(block.block)
                                                      : box_store_->tree(block.block);
  if (tree == nullptr) return nullptr;
  const Vec3i first = ranges_.layout.ownedCells(ranges_.layout.indexOf(block.block)).lo;
  auto drawn = std::make_shared<const DrawnBoxes>(*tree, BoxVisibility(*table_, source_.layout()),
                                                  translate(block.cells, first * -1),
                                                  boxCost(1 / frame_options_.step_vox));
  if (drawn_boxes_bytes_ + drawn->bytes() <= budgets_.boxes / 2) {
    drawn_boxes_bytes_ += drawn->bytes();
    drawn_boxes_.emplace(position, drawn);
  }
  return drawn;
}

Box3 Session::crop() const {
  return cropCells(frame_options_, ranges_.layout.dims);
}

BoxDraw Session::boxDraw(const TextureBlock& block) const {
  BoxDraw box;
  box.cells = block.cells;
  box.axes = textureAxes(block.trimming_axis);
  for (int a = 0; a < 3; ++a)
    box.texel_origin[a] = block.voxels.lo[box.axes[static_cast<size_t>(a)]] - block.at[a];
  return box;
}

StageSeconds Session::workerSeconds() const {
  StageSeconds seconds;
  seconds.read = blocks_.readSeconds();
  seconds.decode = blocks_.decodeSeconds();
  seconds.copy = chunks_.copySeconds();
  return seconds;
}

MovedBytes Session::movedBytes() const {
  return {blocks_.counters().decoded_bytes, chunks_.counters().decoded_bytes,
          device_.uploadedBytes()};
}

MovedBytes Session::rebuildBytes() const {
  MovedBytes bytes;
  const auto voxel_bytes = static_cast<uint64_t>(options_.page.bytes_per_voxel);
  for (const TextureBlock& block : plan_->blocks) {
    const Box3 stored = ranges_.layout.storedVoxels(ranges_.layout.indexOf(block.block));
    bytes.decoded += static_cast<uint64_t>(stored.count()) * bytesPerVoxel(source_.layout().type);
    bytes.copied += static_cast<uint64_t>(block.voxels.count()) * voxel_bytes;
  }
  bytes.uploaded = plan_->bytes();
  return bytes;
}

ReadAhead::Deadline Session::deadline(std::chrono::steady_clock::time_point begin) const {
  if (!frame_options_.time_limit_s) return std::nullopt;
  const std::chrono::duration<double> waiting(*frame_options_.time_limit_s - last_draw_s_);
  return begin + std::chrono::duration_cast<std::chrono::nanoseconds>(waiting);
}

}  // namespace sluice

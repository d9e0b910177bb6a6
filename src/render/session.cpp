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
bool sameCrop(const FrameOptions& a, const FrameOptions& b) {
  return a.crop == b.crop;
}

}  // namespace

namespace {

// The largest chunk: two whole blocks side by side, in whole pages.
uint64_t largestChunkBytes(const PageGeometry& page, int64_t block_vox) {
  return static_cast<uint64_t>(page.pagesOf(Vec3i{2 * block_vox, block_vox, block_vox}) *
                               page.pageBytes());
}

}  // namespace

uint64_t leastBufferBytes(const PageGeometry& page, int64_t block_vox, int threads) {
  const int64_t block_bytes = volume(Vec3i{block_vox, block_vox, block_vox}) * page.bytes_per_voxel;
  return 2 * largestChunkBytes(page, block_vox) + static_cast<uint64_t>(2 * threads * block_bytes);
}

Budgets shareMemory(uint64_t memory_bytes, const PageGeometry& page, bool textures_in_memory,
                    int64_t block_vox, int threads) {
  Budgets budgets;
  budgets.texture_cache = static_cast<uint64_t>(page.cacheBytes());
  const uint64_t least_buffers = leastBufferBytes(page, block_vox, threads);
  const uint64_t textures = textures_in_memory ? budgets.texture_cache + kSpareTextureBytes : 0;
  if (memory_bytes < textures + least_buffers)
    fail(
        "--memory {} is too small: {} of textures and {} of buffers are the least that works; "
        "give --memory {} or fewer --pages",
        formatBytes(memory_bytes), formatBytes(textures), formatBytes(least_buffers),
        textures + least_buffers);
  const uint64_t rest = memory_bytes - textures;
  budgets.texture_buffer = std::max(2 * largestChunkBytes(page, block_vox), rest / 3);
  budgets.volume_buffer = rest - budgets.texture_buffer;
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
                           ranges.layout.size, pool.threads())),
      blocks_(source, ranges.layout, budgets_.volume_buffer),
      chunks_(blocks_, pool, budgets_.texture_buffer),
      cache_(static_cast<uint64_t>(options.page.pages),
             static_cast<uint64_t>(options.page.pageBytes()),
             makePolicy(options.policy, static_cast<uint64_t>(options.page.pages), options.seed)),
      first_id_(device.takeIdRange()) {
  SLUICE_CHECK_EQ(options.page.bytes_per_voxel,
                  static_cast<int64_t>(bytesPerVoxel(ranges.map.type)));
  SLUICE_CHECK_EQ(options.lit, ranges.layout.ghost == 1);
}

Session::~Session() {
  // The device outlives us: leave it without our chunks.
  for (uint64_t id = first_id_; id < first_id_ + chunk_names_.count(); ++id)
    if (cache_.contains(id)) device_.evict(id);
}

void Session::setTransferFunction(const TransferFunction& transfer) {
  transfer_ = transfer;
  table_.reset();
  classification_.reset();
  plan_.reset();
}

void Session::setOptions(const FrameOptions& options) {
  if (!sameCrop(options, frame_options_)) classification_.reset();
  if (!samePlan(options, frame_options_)) plan_.reset();
  frame_options_ = options;
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

}  // namespace sluice

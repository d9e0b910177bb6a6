#include "src/cpu/cpu_device.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "src/base/error.h"
#include "src/cpu/kernels/kernel_box.h"
#include "src/cpu/least_opacity.h"
#include "src/device/drawing_cost.h"

namespace sluice {
namespace {

constexpr int64_t kMostPixels = 1 << 14;
// Boxes are put off until they have about so many samples, or are so many: tiles of fewer leave
// threads waiting, and reading goes on meanwhile.
constexpr double kMostPutOffSamples = 1 << 25;
constexpr size_t kMostPutOffBoxes = 1 << 16;
// If more than this share of a chunk's bricks shows something, looking for empty ones costs more
// than it saves.
constexpr double kMostShownToLeap = 0.9;
// The fewest leap grids of evicted chunks after which those of lost texels are thrown away.
constexpr size_t kMostEvicted = 64;
}  // namespace

void eachTile(WorkerPool& pool, int64_t tiles, const std::function<void(int64_t tile)>& body) {
  // A cache line each, so that threads do not wait for each other's counters.
  struct alignas(64) Share {
    std::atomic<int64_t> next;
    int64_t end;
  };
  const auto threads = static_cast<size_t>(pool.threads());
  std::vector<Share> shares(threads);
  for (size_t i = 0; i < threads; ++i) {
    shares[i].next = tiles * static_cast<int64_t>(i) / pool.threads();
    shares[i].end = tiles * static_cast<int64_t>(i + 1) / pool.threads();
  }
  std::atomic<bool> has_failed = false;
  pool.parallelFor(pool.threads(), [&](int64_t) {
    const auto self = static_cast<size_t>(pool.self());
    for (size_t i = 0; i < threads; ++i) {
      Share& share = shares[(self + i) % threads];
      // Threads may pass the end by one each, which does no harm.
      for (int64_t tile = share.next++; tile < share.end && !has_failed; tile = share.next++) try {
          body(tile);
        } catch (...) {
          has_failed = true;
          throw;
        }
    }
  });
}

CpuDevice::CpuDevice(WorkerPool& pool, SimdTarget target)
    : pool_(pool),
      kernels_(kernelsOf(target)),
      renderer_(fmt::format("SIMD {}, {} thread{}", kernels_.name, pool.threads(),
                            pool.threads() == 1 ? "" : "s")) {}

DeviceLimits CpuDevice::limits() const {
  return {kMostPixels, TexelPlace::kBorrowed};
}

void CpuDevice::makeResident(uint64_t id, ChunkTexelsPtr texels) {
  Leaps leaps;
  if (const auto known = evicted_.find(texels.get()); known != evicted_.end()) {
    // Another chunk may lie at the same address: only the same texels have this leap grid.
    if (known->second.texels.lock() == texels) leaps = std::move(known->second.leaps);
    evicted_.erase(known);
  }
  const bool fresh =
      resident_.emplace(id, Resident{std::move(texels), false, std::move(leaps)}).second;
  SLUICE_CHECK(fresh);
}

void CpuDevice::evict(uint64_t id) {
  const auto found = resident_.find(id);
  SLUICE_CHECK(found != resident_.end());
  // Boxes that were put off still draw from these texels.
  SLUICE_CHECK(!sum_ || !found->second.is_put_off);
  if (found->second.is_put_off) drawNow();
  auto [texels, is_put_off, leaps, channel] = std::move(found->second);
  resident_.erase(found);
  // Without its texels, so that level 3 may drop them.
  if (leaps.grid) evicted_[texels.get()] = {texels, std::move(leaps)};
  texels.reset();
  if (evicted_.size() <= most_evicted_) return;
  std::erase_if(evicted_, [](const auto& known) { return known.second.texels.expired(); });
  // The next look comes after as many evictions as there are grids to look at, so that a frame of
  // many small chunks, all of which stay in the level below, does not look at all of them each
  // time.
  most_evicted_ = 2 * evicted_.size() + kMostEvicted;
}

void CpuDevice::beginFrame(const FrameSetup& setup, const StopToken& stop) {
  SLUICE_CHECK_LE(setup.clip_planes.size(), kMostClipPlanes);
  requirePictureSize(setup.size, limits());
  if (sum_) {
    stop_ = stop;
    sum_->setups.push_back(setup);
    sum_->boxes.emplace_back();
    return;
  }
  forgetPutOff();
  setup_ = setup;
  stop_ = stop;
  taken_ = 0;
  // Only lit frames look at the light, which takes a pass over its texels.
  if (setup_.lit) light_squares_.take(setup_.light, pool_);
  // Only the composite kernels leap.
  leaps_ = setup_.skips && traitsOf(setup_.mode).hides;
  const size_t channels = 1 + setup_.others.size();
  SLUICE_CHECK_LE(channels, kMostBlended);
  while (looks_.size() < channels) looks_.push_back(std::make_unique<ChannelLook>());
  takeLook(setup_, *looks_.front());
  for (size_t i = 1; i < channels; ++i) takeLook(setup_.others[i - 1], *looks_[i]);
  drawing_ = {&kernels_, {}, channels};
  for (size_t i = 0; i < channels; ++i) drawing_.frames[i] = &looks_[i]->tables->frame();
  picture_.begin(setup_, kernels_, rowsOfFrame());
  if (setup_.is_part) parts_.begin(setup_, drawing_);
}

void CpuDevice::takeLook(const FrameSetup& setup, ChannelLook& look) {
  const bool is_one = setup_.others.empty() && !setup_.is_one_of_several;
  const Channels channels = is_one ? Channels::kOne : Channels::kSeveral;
  if (!look.look_up || look.look_up->channels != channels || look.look_up->key != lookUpKey(setup))
    look.look_up.emplace(lookUpKey(setup), channels);
  look.tables.emplace(setup, *look.look_up, setup.lit ? light_squares_.texels() : nullptr);
  if (!leaps_ || look.shown_for == setup.look_up) return;
  ShownValues shown = shownValues(*setup.look_up);
  // Distances depend on the values that show, not on their colours: looks that show the same keep
  // them.
  if (shown != look.shown || look.shown_number == 0) look.shown_number = ++shown_numbers_;
  look.shown = std::move(shown);
  look.shown_for = setup.look_up;
}

PictureRows CpuDevice::rowsOfFrame() const {
  const int height = setup_.size.height;
  if (!rows_) return {0, height};
  SLUICE_CHECK(!setup_.is_part);
  return {rows_->lo, std::min(rows_->hi, height)};
}

TileBins CpuDevice::binsOf(const std::vector<KernelBox>& boxes) const {
  return tileBins(boxes, picture_.tilesAcross(), picture_.tilesUp(), picture_.lowestTiles());
}

void CpuDevice::draw(std::span<const BoxDraw> boxes) {
  stop_.throwIfStopped();
  const uint32_t added = sum_ ? static_cast<uint32_t>(sum_->setups.size()) - 1 : 0;
  for (size_t i = 0; i < boxes.size(); ++i) {
    // A chunk is looked up once for all of its boxes in a row.
    if (i == 0 || boxes[i].chunk != boxes[i - 1].chunk) {
      const auto found = resident_.find(boxes[i].chunk);
      SLUICE_CHECK(found != resident_.end());
      found->second.is_put_off = true;
      found->second.channel = sum_ ? added : boxes[i].channel;
      ++binds_;
    }
    if (sum_) {
      sum_->boxes.back().push_back(boxes[i]);
      continue;
    }
    put_off_.push_back(boxes[i]);
    put_off_samples_ += aboutSamples(setup_, boxes[i].cells);
  }
  if (put_off_samples_ > kMostPutOffSamples || put_off_.size() > kMostPutOffBoxes) drawNow();
}

void CpuDevice::forgetPutOff() {
  if (put_off_.empty()) return;
  put_off_.clear();
  put_off_samples_ = 0;
  for (auto& [id, chunk] : resident_) chunk.is_put_off = false;
}

void CpuDevice::prepareLeaps() {
  // Segments and surfaces look half a slice before and behind a sample, which may be beside its
  // brick.
  const int64_t margin = setup_.integrates || setup_.has_surfaces ? 1 : 0;
  std::vector<Resident*> stale;
  for (auto& [id, chunk] : resident_) {
    if (!chunk.is_put_off) continue;
    Leaps& leaps = chunk.leaps;
    if (leaps.grid && leaps.grid->margin != margin) leaps.grid.reset();
    if (!leaps.grid || leaps.made_for != looks_[chunk.channel]->shown_number)
      stale.push_back(&chunk);
  }
  pool_.parallelFor(static_cast<int64_t>(stale.size()), [&](int64_t i) {
    auto& [texels, is_put_off, leaps, channel] = *stale[static_cast<size_t>(i)];
    const ChannelLook& look = *looks_[channel];
    if (!leaps.grid) leaps.grid = leapGrid(*texels, look.shown_for->expected.get(), margin);
    setDistances(*leaps.grid, texels->type, look.shown);
    leaps.made_for = look.shown_number;
  });
}

std::vector<KernelBox> CpuDevice::kernelBoxes() const {
  std::vector<KernelBox> boxes;
  boxes.reserve(put_off_.size());
  std::vector<ChannelBox> joined;
  const bool may_join = !setup_.others.empty() || setup_.has_surfaces;
  const auto appendGroup = [&] {
    if (setup_.has_surfaces && joined.size() == 1)
      appendBox(setup_, joined[0].box, joined[0].chunk, joined[0].leaps, boxes);
    else
      appendJoined(setup_, joined, boxes);
    joined.clear();
  };
  for (const BoxDraw& box : put_off_) {
    const Resident& chunk = resident_.at(box.chunk);
    SLUICE_CHECK(!chunk.texels->has_spread || drawsSpreads(setupOfChannel(setup_, box.channel)));
    const bool leaps = leaps_ && chunk.leaps.grid->shown_share < kMostShownToLeap;
    const LeapGrid* const grid = leaps ? &*chunk.leaps.grid : nullptr;
    if (!may_join) {
      appendBox(setup_, box, chunk.texels.get(), grid, boxes);
      continue;
    }
    // A box that does not join begins a block: the boxes before it are complete.
    if (!box.joins) appendGroup();
    joined.push_back({box, chunk.texels.get(), grid});
  }
  appendGroup();
  return boxes;
}

void CpuDevice::drawNow(const Then& then, Keep keep) {
  stop_.throwIfStopped();
  if (put_off_.empty() && !then) return;
  if (leaps_) prepareLeaps();
  const std::vector<KernelBox> boxes = kernelBoxes();
  forgetPutOff();
  const TileBins bins = binsOf(boxes);
  const bool in_layers = traitsOf(setup_.mode).needs_order && setup_.is_part;
  // endFrame() copies each tile at once, so that its pixels need no memory beyond the thread's.
  if (keep == Keep::kPixels) picture_.makeRoom();
  eachTile(pool_, picture_.tiles(), [&](int64_t index) {
    std::span<const uint32_t> rest = bins.of(index);
    TiledPicture::Scratch scratch;
    // Tiles without boxes are only passed on to `then`.
    TilePixels tile = rest.empty()            ? picture_.drawnTile(index)
                      : keep == Keep::kPixels ? picture_.tile(index)
                                              : picture_.tile(index, scratch);
    for (stop_.throwIfStopped(); !rest.empty(); stop_.throwIfStopped()) {
      const auto part = rest.first(std::min(kBoxesBetweenStops, rest.size()));
      // In layers, each part of a tile is taken out behind the boxes of its layer.
      if (in_layers)
        parts_.draw(index, boxes, part, tile);
      else
        drawing_.draw(boxes.data(), part.data(), part.size(), tile);
      rest = rest.subspan(part.size());
    }
    if (tile.taken > 0) taken_ += tile.taken;
    if (then) then(tile);
  });
  if (in_layers) checkPartRoom(parts_.bytes(), setup_.most_part_bytes);
}

std::vector<float> CpuDevice::leastOpacity(const MapGrid& grid) {
  SLUICE_CHECK(traitsOf(setup_.mode).hides);
  LeastOpacity least(grid, setup_.size);
  drawNow([&](const TilePixels& tile) { least.add(picture_, tile); });
  return least.cells();
}

void CpuDevice::stopOpaque() {
  SLUICE_CHECK(traitsOf(setup_.mode).hides);
  drawNow();
  picture_.stopOpaque(static_cast<float>(setup_.opacity_threshold));
}

uint64_t CpuDevice::countSamples(std::span<const BoxDraw> draws) {
  // The same boxes as the picture's, but without texels: counting reads none.
  std::vector<KernelBox> boxes;
  boxes.reserve(draws.size());
  for (const BoxDraw& box : draws) appendBox(setup_, box, nullptr, nullptr, boxes);
  const TileBins bins = binsOf(boxes);
  std::atomic<uint64_t> samples = 0;
  pool_.parallelFor(picture_.tiles(), [&](int64_t index) {
    const auto of_tile = bins.of(index);
    if (of_tile.empty()) return;
    samples += kernels_.count(drawing_.frame(), boxes.data(), of_tile.data(), of_tile.size(),
                              picture_.drawnTile(index));
  });
  return samples;
}

uint64_t CpuDevice::takenSamples() {
  SLUICE_CHECK(drawing_.frame().counts_taken);
  return taken_;
}

Picture CpuDevice::endFrame() {
  if (sum_) return {};
  // The memory of the last picture that was given back.
  Picture picture = std::exchange(spare_, {});
  picture_.shape(picture, stop_);
  const bool resolves = !traitsOf(setup_.mode).has_colors && !setup_.is_part;
  const auto finish = [&](const TilePixels& tile) {
    picture_.copyTile(tile, picture);
    if (!resolves) return;
    picture_.eachRow(tile, picture, [&](std::span<float> rgba) { resolveMode(setup_, 1, rgba); });
  };
  drawNow(finish, Keep::kNothing);
  stop_.throwIfStopped();
  return picture;
}

PartialPicture CpuDevice::endPart() {
  SLUICE_CHECK(setup_.is_part);
  drawNow();
  stop_.throwIfStopped();
  // Without an order, a tile is one part, taken out at the end.
  if (!traitsOf(setup_.mode).needs_order)
    pool_.parallelFor(picture_.tiles(), [&](int64_t index) {
      const TilePixels tile = picture_.drawnTile(index);
      if (tile.color[0] != nullptr) parts_.takeOut(index, tile);
    });
  return parts_.end();
}

}  // namespace sluice

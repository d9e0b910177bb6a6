// A Drawing's reports on its look, its last picture and the levels of memory.
#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "src/classify/transfer/transfer_file.h"
#include "src/library/drawing/drawing.h"

namespace sluice {
namespace {

std::vector<ShownLook::Color> shownColors(const TransferFunction& transfer) {
  std::vector<ShownLook::Color> colors;
  colors.reserve(transfer.colors.size());
  for (const ColorPoint& point : transfer.colors)
    colors.push_back({point.value, {point.rgb.x, point.rgb.y, point.rgb.z}});
  return colors;
}

ShownLook::Channel shownChannel(const Layer& layer) {
  const TransferFunction& transfer = layer.look.transfer;
  ShownLook::Channel shown{.channel = layer.volume.channel.id(),
                           .name = layer.volume.channel.name,
                           .rgb = {1, 1, 1},
                           .range = {0, 1}};
  shown.colors = shownColors(transfer);
  if (!shown.colors.empty()) {
    shown.rgb = shown.colors.back().rgb;
    shown.range = {shown.colors.front().value, shown.colors.back().value};
  }
  shown.labels = transfer.labels;
  for (const OpacityPoint& point : transfer.opacities)
    shown.opacity = std::max(shown.opacity, point.opacity);
  if (transfer.labels) shown.opacity = layer.look.label_opacity;
  return shown;
}

}  // namespace

std::string Drawing::deviceName() const {
  return fmt::format("{}, {}", scene_.device->backend(), scene_.device->renderer());
}

ShownLook Drawing::shownLook() const {
  ShownLook shown;
  shown.colors = shownColors(scene_.look.transfer);
  for (const OpacityPoint& point : scene_.look.transfer.opacities)
    shown.opacities.push_back({point.value, point.opacity});
  for (const auto& [label, name] : scene_.look.label_names)
    shown.label_names.push_back({label, name});
  for (const IsoSurface& surface : scene_.look.transfer.surfaces)
    shown.surfaces.push_back({surface.value, {surface.rgb.x, surface.rgb.y, surface.rgb.z}});
  if (!scene_.more.empty())
    for (const Layer* layer : scene_.layers()) shown.channels.push_back(shownChannel(*layer));
  shown.lit = scene_.look.lit;
  shown.blends = scene_.blends();
  shown.labels = scene_.look.transfer.labels;
  shown.options = scene_.lookText();
  shown.transfer = writeTransferFunction(scene_.look.transfer);
  shown.warnings = scene_.lookWarnings();
  return shown;
}

RenderReport Drawing::report(bool maps) const {
  const auto level = [](const CacheCounters& c) {
    return LevelReport{.requests = c.requests,
                       .hits = c.hits,
                       .misses = c.misses,
                       .loads = c.loads,
                       .evictions = c.evictions,
                       .current_bytes = c.current_bytes,
                       .peak_bytes = c.peak_bytes,
                       .budget_bytes = c.budget_bytes};
  };
  const TextureCache& cache = session().textureCache();
  const LevelCounters counters = scene_.levelCounters();
  RenderReport report;
  report.seconds = report_.seconds;
  report.draw_seconds = report_.stages.draw;
  report.missing_share = report_.missing_share;
  report.step_vox = report_.step_vox;
  report.why_empty = why_empty_;
  report.empty_channels = empty_channels_;
  report.why_added = scene_.why_added;
  report.white = report_.blocks.white;
  report.grey = report_.blocks.grey;
  report.black = report_.blocks.black;
  if (report_.cut) {
    report.coarse_share = report_.cut->coarse_share;
    report.is_refined = report_.cut->is_final;
    report.will_improve = report_.cut->will_improve;
    for (const CutSummary::Level& shown : report_.cut->levels) report.levels.push_back(shown.level);
  }
  report.pages_loaded = report_.pages_loaded;
  report.read_bytes = scene_.storedBytesRead();
  report.volume_buffer = level(counters.volume_buffer);
  report.texture_buffer = level(counters.texture_buffer);
  report.texture_cache = level(counters.texture_cache);
  report.pages = counters.pages;
  report.page_bytes = static_cast<uint64_t>(session().page().pageBytes());
  if (!maps) return report;
  // The first channel's chunks, numbered in the order of their first pages.
  std::unordered_map<ChunkId, uint32_t> numbers;
  for (const ChunkId chunk : cache.pageMap())
    report.page_chunks.push_back(
        chunk == TextureCache::kNoChunk
            ? 0
            : numbers.try_emplace(chunk, static_cast<uint32_t>(numbers.size() + 1)).first->second);
  const Vec3i grid = opened_->volume.layout.grid;
  report.block_grid = {grid.x, grid.y, grid.z};
  report.block_classes = blockClasses();
  return report;
}

std::vector<uint8_t> Drawing::blockClasses() const {
  const int64_t blocks = opened_->volume.layout.blockCount();
  const VisibleBlocksPtr visible = session().lastVisible();
  if (visible == nullptr || blocks > RenderReport::kMostMappedBlocks) return {};
  std::vector<uint8_t> classes(static_cast<size_t>(blocks), 0);
  const BlockLayout& finest = opened_->volume.layout;
  const PyramidLayout pyramid = opened_->volume.step().layout();
  for (const ObjectBlock& block : visible->blocks) {
    const uint8_t kind = block.kind == BlockClass::kBlack ? 2 : 1;
    // A coarse block stands for all finest blocks below it.
    const Box3 covered = pyramid.finestBlocksOf(block.name);
    for (int64_t z = covered.lo.z; z < covered.hi.z; ++z)
      for (int64_t y = covered.lo.y; y < covered.hi.y; ++y)
        for (int64_t x = covered.lo.x; x < covered.hi.x; ++x)
          classes[static_cast<size_t>(finest.idOf({x, y, z}))] = kind;
  }
  return classes;
}

}  // namespace sluice

#include "tools/outputs/report.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include <array>
#include <cmath>

#include "io/web/address.h"
#include "src/base/sources/volume_times.h"
#include "src/base/threads/clock.h"
#include "src/base/values/corners.h"
#include "src/library/opening/thick_source.h"
#include "src/render/camera/index_space.h"
#include "tools/outputs/cut_report.h"

namespace sluice {

using nlohmann::json;

json occlusionJson(const OcclusionReport& report) {
  return {{"updates_wanted", report.updates_wanted},
          {"updates", report.updates},
          {"cells", report.cells},
          {"cells_culled", report.cells_culled},
          {"cells_clipped", report.cells_clipped},
          {"skipped_share", report.skippedShare()},
          {"chunks_hidden", report.chunks_hidden},
          {"seconds", report.seconds}};
}

namespace {

json channelsJson(const std::vector<LayerFrame>& layers) {
  json channels = json::array();
  for (const LayerFrame& layer : layers) {
    const FrameReport& report = layer.report;
    channels.push_back({{"seconds", report.seconds},
                        {"samples_drawn", report.samples_drawn},
                        {"samples_taken", report.samples_taken},
                        {"chunks", report.chunks},
                        {"pages_loaded", report.pages_loaded},
                        {"decoded_bytes", report.decoded_bytes},
                        {"blocks",
                         {{"white", report.blocks.white},
                          {"grey", report.blocks.grey},
                          {"black", report.blocks.black}}},
                        {"empty", !layer.shows_something}});
    if (report.cut) channels.back()["cut"] = cutJson(*report.cut);
  }
  return channels;
}

json plainFrameJson(const RenderedFrame& frame) {
  const FrameReport& report = frame.report;
  const StageSeconds& s = report.stages;
  return {{"seconds", report.seconds},
          {"stages",
           {{"classify", s.classify},
            {"plan", s.plan},
            {"read", s.read},
            {"decode", s.decode},
            {"copy", s.copy},
            {"upload", s.upload},
            {"draw", s.draw},
            {"boxes", s.boxes},
            {"write", frame.write_seconds}}},
          {"samples_drawn", report.samples_drawn},
          {"samples_taken", report.samples_taken},
          {"samples_object", report.samples_object},
          {"boxes_drawn", report.boxes_drawn},
          {"chunks", report.chunks},
          {"pages", report.pages},
          {"pages_loaded", report.pages_loaded},
          {"decoded_bytes", report.decoded_bytes},
          {"copied_bytes", report.copied_bytes},
          {"uploaded_bytes", report.uploaded_bytes},
          {"rebuild",
           {{"decoded_bytes", report.rebuild.decoded},
            {"copied_bytes", report.rebuild.copied},
            {"uploaded_bytes", report.rebuild.uploaded}}},
          {"blocks",
           {{"white", report.blocks.white},
            {"grey", report.blocks.grey},
            {"black", report.blocks.black}}},
          {"blocks_before",
           {{"white", report.before.white},
            {"grey", report.before.grey},
            {"black", report.before.black}}},
          {"complete", report.missing_share == 0},
          {"missing_share", report.missing_share},
          {"occlusion", occlusionJson(report.occlusion)},
          {"binds", report.binds},
          {"empty", frame.empty}};
}

}  // namespace

json frameJson(const RenderedFrame& frame) {
  json made = plainFrameJson(frame);
  if (const Vec3i texels = frame.report.light_texels; texels.x > 0)
    // Pictures whose light does not look around have no such grid.
    made["light"] = {{"texels", {texels.x, texels.y, texels.z}},
                     {"seconds", frame.report.stages.light}};
  if (frame.layers.size() > 1) made["channels"] = channelsJson(frame.layers);
  return made;
}

json countersJson(const CacheCounters& c) {
  return {{"requests", c.requests},
          {"hits", c.hits},
          {"misses", c.misses},
          {"coalesced", c.coalesced},
          {"failures", c.failures},
          {"loads", c.loads},
          {"redundant_loads", c.redundant_loads},
          {"evictions", c.evictions},
          {"current_bytes", c.current_bytes},
          {"peak_bytes", c.peak_bytes},
          {"budget_bytes", c.budget_bytes},
          {"decoded_bytes", c.decoded_bytes},
          {"packs", c.packs},
          {"unpacks", c.unpacks}};
}

json lookJson(const ChosenLook& look) {
  return {{"name", look.transfer.name},
          {"options", look.options()},
          {"lit", look.lit},
          {"labels", look.transfer.labels}};
}

WorldBounds worldBounds(const VolumeLayout& layout) {
  const Vec3d last = toDouble(layout.dims - Vec3i{1, 1, 1});
  WorldBounds bounds{worldFromIndex(layout, {}), worldFromIndex(layout, {})};
  for (int corner = 1; corner < 8; ++corner) {
    const Vec3d world = worldFromIndex(layout, cornerOf({}, last, corner));
    bounds = {min(bounds.lo, world), max(bounds.hi, world)};
  }
  return bounds;
}

std::string axisLetters(const VolumeLayout& layout) {
  // Letters of the world's axes, towards their positive and negative ends.
  std::array<std::string_view, 2> letters;
  if (layout.frame == WorldFrame::kRas) letters = {"RAS", "LPI"};
  if (layout.frame == WorldFrame::kLps) letters = {"LPS", "RAI"};
  if (letters[0].empty()) return "";
  std::string text;
  std::array<bool, 3> taken{};
  for (const Vec3d& axis : layout.axes) {
    int main = 0;
    for (int a = 1; a < 3; ++a)
      if (std::abs(axis[a]) > std::abs(axis[main])) main = a;
    if (taken[static_cast<size_t>(main)]) return "";  // turned by half a right angle
    taken[static_cast<size_t>(main)] = true;
    text += letters[axis[main] < 0 ? 1 : 0][static_cast<size_t>(main)];
  }
  return text;
}

std::string_view name(WorldFrame frame) {
  switch (frame) {
    case WorldFrame::kRas:
      return "ras";
    case WorldFrame::kLps:
      return "lps";
    case WorldFrame::kPictureRows:
      return "picture-rows";
    case WorldFrame::kYUp:
      return "y-up";
    case WorldFrame::kNone:
      break;
  }
  return "none";
}

std::string uprightHint(const VolumeLayout& layout) {
  if (layout.frame == WorldFrame::kPictureRows)
    return "not known for slices; --up 0,0,1 or --up 0,0,-1 stands the stack upright";
  if (layout.frame == WorldFrame::kNone)
    return "not in the file; --up 0,0,1, --up 0,0,-1 or --up 0,-1,0 turns the picture upright";
  return "";
}

// Null: the file does not tell them.
static json timesJson(const VolumeSource& source) {
  const std::optional<TimeAxis> times = timesOf(source);
  if (!times) return {};
  return {{"step", times->step}, {"start", times->start}, {"unit", times->unit}};
}

json volumeJson(const IndexedVolume& volume) {
  const VolumeLayout& layout = storedLayout(*volume.source);
  const ValueRange range = volume.finiteRange();
  const auto triple = [](auto v) { return json::array({v.x, v.y, v.z}); };
  const VolumeLayout& drawn = volume.source->layout();
  const WorldBounds bounds = worldBounds(drawn);
  // Level 0, or the coarser one that stands in for it while it has no index.
  const int values_level = volume.stand_in ? volume.stand_in->level : 0;
  return {{"name", layout.name},
          {"dims", triple(layout.dims)},
          {"voxel_type", name(layout.type)},
          {"spacing", triple(layout.spacing)},
          {"origin", triple(layout.origin)},
          {"axes", {triple(layout.axes[0]), triple(layout.axes[1]), triple(layout.axes[2])}},
          {"bounds", {triple(bounds.lo), triple(bounds.hi)}},
          {"unit", layout.unit},
          {"orientation", {{"frame", name(layout.frame)}, {"axes", axisLetters(layout)}}},
          {"channels", layout.channels},
          {"channel", layout.channel},
          {"levels", layout.levels},
          {"grids", layout.grids},
          {"notes", drawn.notes},
          {"place_fault", layout.place_fault},
          {"time_steps", layout.time_steps},
          {"times", timesJson(*volume.source)},
          {"value_range", {range.lo, range.hi}},
          {"values_level", values_level},
          {"sample", volume.sample ? json(volume.sample->part) : json()},
          {"blocks",
           {{"size", volume.layout.size},
            {"count", volume.layout.blockCount()},
            {"held", volume.index->ranges.blocks.size()}}},
          {"index",
           {{"path", volume.index->path.string()},
            {"state", name(volume.index->origin)},
            {"note", volume.index->note},
            {"bytes", volume.index->bytes()}}}};
}

json idJson(const ShownChannel& channel) {
  return channel.is_over ? json(channel.id()) : json(channel.number);
}

namespace {

// A texture cache, or those of all channels.
json textureCacheJson(const LevelCounters& counters, const PageGeometry& page) {
  json cache = countersJson(counters.texture_cache);
  cache.update({{"pages", counters.pages},
                {"page_bytes", page.pageBytes()},
                {"page", printPageSize(page.size_vox)},
                {"pages_loaded", counters.pages_loaded}});
  return cache;
}

// The counters of all channels.
json levelsJson(const Scene& scene) {
  const LevelCounters counters = scene.levelCounters();
  json levels;
  levels["disk"] = {{"read_bytes", scene.storedBytesRead()}};
  levels["volume_buffer"] = countersJson(counters.volume_buffer);
  levels["texture_buffer"] = countersJson(counters.texture_buffer);
  levels["texture_cache"] = textureCacheJson(counters, scene.session->page());
  levels["texture_cache"].update(
      {{"uploaded_bytes", scene.device->uploadedBytes()}, {"binds", scene.device->binds()}});
  return levels;
}

// The counters of a channel.
json levelsJson(const Layer& layer) {
  const LevelCounters counters = countersOf(*layer.session);
  json levels;
  levels["disk"] = {{"read_bytes", layer.volume.source->storedBytesRead()}};
  levels["volume_buffer"] = countersJson(counters.volume_buffer);
  levels["texture_buffer"] = countersJson(counters.texture_buffer);
  levels["texture_cache"] = textureCacheJson(counters, layer.session->page());
  levels["texture_cache"]["uploaded_bytes"] = layer.uploaded_bytes;
  return levels;
}

// Each channel, with its own look and memory.
json channelsJson(const Scene& scene) {
  json channels = json::array();
  for (const Layer* layer : scene.layers())
    channels.push_back({{"channel", idJson(layer->volume.channel)},
                        {"name", layer->volume.channel.name},
                        {"look", lookJson(layer->look)},
                        {"read_bytes", layer->volume.source->storedBytesRead()},
                        {"levels", levelsJson(*layer)},
                        {"memory_bytes", memoryBudget(layer->machine)}});
  return channels;
}

// The lines that opening the volumes and choosing their looks print as warnings.
std::vector<std::string> warningsOf(const Scene& scene) {
  std::vector<std::string> lines = scene.lookWarnings();
  for (const Layer* layer : scene.layers())
    for (const std::string& note : layer->volume.notes)
      if (std::ranges::find(lines, note) == lines.end()) lines.push_back(note);
  return lines;
}

}  // namespace

json sceneJson(const Scene& scene, const std::vector<RenderedFrame>& frames) {
  json report;
  report["volume"] = volumeJson(scene.volume);
  report["frames"] = json::array();
  for (const RenderedFrame& frame : frames) report["frames"].push_back(frameJson(frame));
  const FrameReport& last = frames.back().report;
  report["blocks"] = {
      {"white", last.blocks.white}, {"grey", last.blocks.grey}, {"black", last.blocks.black}};
  report["transfer"] = scene.look.transfer.name;
  report["look"] = lookJson(scene.look);
  report["look"]["options"] = scene.drawn_look;
  report["warnings"] = warningsOf(scene);

  if (last.cut) report["cut"] = cutJson(*last.cut);
  report["levels"] = levelsJson(scene);
  if (!scene.more.empty()) report["channels"] = channelsJson(scene);
  uint64_t part_bytes = 0, beside_bytes = 0;
  for (const Layer* layer : scene.layers()) {
    part_bytes += layer->part_bytes;
    beside_bytes += layer->beside_bytes;
  }
  report["memory_bytes"] = scene.memory_bytes;
  report[scene.share ? "part_memory_bytes" : "picture_memory_bytes"] = part_bytes;
  report["beside_memory_bytes"] = beside_bytes;
  report["peak_rss_bytes"] = peakResidentBytes();
  report["peak_anonymous_bytes"] = std::max(scene.peak_anonymous_bytes, anonymousBytes());
  report["device"] = nameOf(*scene.device);
  report["gl"] = {{"backend", scene.device->backend()}, {"renderer", scene.device->renderer()}};
  report["version"] = SLUICE_VERSION;
  return report;
}

json optionsJson(const CLI::App& app) {
  json options = json::object();
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_single_name();
    if (name == "help" || (option->count() == 0 && option->get_default_str().empty())) continue;
    if (option->count() == 0) {
      options[name] = option->get_default_str();
    } else if (option->get_expected_max() == 0) {
      options[name] = true;
    } else {
      std::vector<std::string> words = option->results();
      // Addresses may hold a password or a signature, and reports are passed on.
      for (std::string& word : words) word = withoutSecrets(word);
      if (words.size() == 1 && name != "volume")
        options[name] = words.front();
      else
        options[name] = std::move(words);
    }
  }
  return options;
}

}  // namespace sluice

#include "tools/report.h"

#include <CLI/CLI.hpp>

#include "src/base/clock.h"

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

json frameJson(const RenderedFrame& frame) {
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
          {"blocks", {{"white", report.white}, {"grey", report.grey}, {"black", report.black}}},
          {"blocks_before",
           {{"white", report.before.white},
            {"grey", report.before.grey},
            {"black", report.before.black}}},
          {"complete", report.missing_share == 0},
          {"missing_share", report.missing_share},
          {"occlusion", occlusionJson(report.occlusion)},
          {"binds", report.binds}};
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

json volumeJson(const IndexedVolume& volume) {
  const VolumeLayout& layout = volume.source->layout();
  const ValueRange range = volume.valueRange();
  const auto triple = [](auto v) { return json::array({v.x, v.y, v.z}); };
  return {{"name", layout.name},
          {"dims", triple(layout.dims)},
          {"voxel_type", name(layout.type)},
          {"spacing", triple(layout.spacing)},
          {"origin", triple(layout.origin)},
          {"axes", {triple(layout.axes[0]), triple(layout.axes[1]), triple(layout.axes[2])}},
          {"time_steps", layout.time_steps},
          {"value_range", {range.lo, range.hi}},
          {"blocks",
           {{"size", volume.layout.size},
            {"count", volume.layout.blockCount()},
            {"held", volume.index.ranges.blocks.size()}}},
          {"index",
           {{"path", volume.index.path.string()},
            {"state", volume.index.state},
            {"note", volume.index.note},
            {"bytes", volume.index.ranges.bytes()}}}};
}

json sceneJson(const Scene& scene, const std::vector<RenderedFrame>& frames) {
  json report;
  report["volume"] = volumeJson(scene.volume);
  report["frames"] = json::array();
  for (const RenderedFrame& frame : frames) report["frames"].push_back(frameJson(frame));
  const FrameReport& last = frames.back().report;
  report["blocks"] = {{"white", last.white}, {"grey", last.grey}, {"black", last.black}};
  report["transfer"] = scene.transfer.name;

  const Session& session = *scene.session;
  const TextureCache& cache = session.textureCache();
  json& levels = report["levels"];
  levels["disk"] = {{"read_bytes", scene.volume.source->storedBytesRead()}};
  levels["volume_buffer"] = countersJson(session.volumeBufferCounters());
  levels["texture_buffer"] = countersJson(session.textureBufferCounters());
  levels["texture_cache"] = countersJson(cache.counters());
  levels["texture_cache"].update({{"pages", cache.capacityPages()},
                                  {"page_bytes", session.page().pageBytes()},
                                  {"page", printPageSize(session.page().size_vox)},
                                  {"pages_loaded", cache.pagesLoaded()},
                                  {"uploaded_bytes", scene.device->uploadedBytes()},
                                  {"binds", scene.device->binds()}});
  report["memory_bytes"] = scene.memory_bytes;
  report["peak_rss_bytes"] = peakResidentBytes();
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
    } else if (option->results().size() == 1 && name != "volume") {
      options[name] = option->results().front();
    } else {
      options[name] = option->results();
    }
  }
  return options;
}

}  // namespace sluice

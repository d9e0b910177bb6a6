#include "python/renderer_handle.h"

#include <pybind11/stl.h>

#include <utility>
#include <vector>

#include "python/keywords.h"
#include "src/options/idle_options.h"

namespace sluice::python {
namespace {

PipelineOptions pipelineOf(const py::dict& keywords) {
  PipelineOptions pipeline;
  py::dict left = keywords.attr("copy")();
  const auto take = [&](const char* keyword, auto& held) {
    takeKeyword(keywords, keyword, held);
    left.attr("pop")(keyword, py::none());
  };
  take("algorithm", pipeline.algorithm);
  take("merge", pipeline.merge);
  take("partition", pipeline.partition);
  take("occlusion", pipeline.occlusion);
  take("policy", pipeline.policy);
  take("seed", pipeline.seed);
  take("pages", pipeline.pages);
  take("simd", pipeline.simd);
  take("gl", pipeline.gl);
  for (const auto& [keyword, value] : left)
    throw py::type_error("unexpected keyword " + py::repr(keyword).cast<std::string>());
  return pipeline;
}

Renderer makeRenderer(const Volume& volume, const std::string& device, uint64_t memory_bytes,
                      int threads, const py::dict& pipeline) {
  using Device = RendererOptions::Device;
  RendererOptions options{
      .memory_bytes = memory_bytes, .threads = threads, .pipeline = pipelineOf(pipeline)};
  if (device == "gl")
    options.device = Device::kGl;
  else if (device == "cpu")
    options.device = Device::kCpu;
  else if (device != "auto")
    throw py::value_error("device: expected one of 'auto', 'gl', 'cpu', found '" + device + "'");
  return run([&](const std::stop_token&) { return Renderer(volume, {}, options); });
}

py::dict memoryOf(const PicturePlan::Memory& memory) {
  return py::dict(
      py::arg("budget_bytes") = memory.budget_bytes, py::arg("least_bytes") = memory.least_bytes,
      py::arg("buffer_bytes") = memory.buffer_bytes, py::arg("index_bytes") = memory.index_bytes,
      py::arg("picture_bytes") = memory.picture_bytes,
      py::arg("program_bytes") = memory.program_bytes, py::arg("peak_bytes") = memory.peak_bytes,
      py::arg("machine_bytes") = memory.machine_bytes, py::arg("fits") = memory.fits);
}

// The levels of resolution, if the volume has several.
void addCut(const PicturePlan& plan, py::dict& out) {
  if (plan.levels.empty()) return;
  py::list levels;
  for (const PicturePlan::Level& each : plan.levels)
    levels.append(py::dict(py::arg("level") = each.level, py::arg("blocks") = each.blocks,
                           py::arg("cells") = each.cells));
  out["cut"] = py::dict(py::arg("levels") = levels, py::arg("coarse_share") = plan.coarse_share,
                        py::arg("final") = plan.is_refined);
}

// The plan as a dict with the names of `sluice plan --json`.
py::dict planned(const PicturePlan& plan) {
  py::dict algorithms;
  for (const PicturePlan::Algorithm& each : plan.algorithms)
    algorithms[py::str(each.name)] =
        py::dict(py::arg("chunks") = each.chunks, py::arg("pages") = each.pages,
                 py::arg("bytes") = each.bytes, py::arg("binds") = each.binds);
  py::dict out;
  out["blocks"] = py::dict(py::arg("white") = plan.white, py::arg("grey") = plan.grey,
                           py::arg("black") = plan.black);
  out["algorithms"] = algorithms;
  out["clusters"] = plan.clusters;
  out["read"] = py::dict(py::arg("blocks") = plan.read_blocks,
                         py::arg("voxel_bytes") = plan.read_voxel_bytes);
  out["most_read"] = py::dict(py::arg("blocks") = plan.most_read_blocks,
                              py::arg("voxel_bytes") = plan.most_read_voxel_bytes);
  out["memory"] = memoryOf(plan.memory);
  out["classify_seconds"] = plan.classify_seconds;
  out["plan_seconds"] = plan.plan_seconds;
  out["seconds"] = plan.classify_seconds + plan.plan_seconds;
  addCut(plan, out);
  if (plan.channels.empty()) return out;
  py::list channels;
  for (const PicturePlan& each : plan.channels) {
    py::dict channel = planned(each);
    // A number, or "over".
    channel["channel"] = each.channel == "over" ? py::object(py::str(each.channel))
                                                : py::object(py::int_(py::str(each.channel)));
    channel["name"] = each.name;
    channels.append(channel);
  }
  out["channels"] = channels;
  return out;
}

py::dict levelOf(const LevelReport& level) {
  py::dict out;
  out["requests"] = level.requests;
  out["hits"] = level.hits;
  out["misses"] = level.misses;
  out["loads"] = level.loads;
  out["evictions"] = level.evictions;
  out["current_bytes"] = level.current_bytes;
  out["peak_bytes"] = level.peak_bytes;
  out["budget_bytes"] = level.budget_bytes;
  return out;
}

}  // namespace

RendererHandle::RendererHandle(const VolumeHandle& volume, const std::string& device,
                               uint64_t memory_bytes, int threads, const py::dict& pipeline)
    : renderer_(makeRenderer(volume.volume.get(), device, memory_bytes, threads, pipeline)) {
  const PipelineOptions asked = pipelineOf(pipeline);
  PictureFacts facts;
  facts.merges = asked.algorithm.empty() || asked.algorithm == "merged";
  facts.is_random = asked.policy == "random";
  warn(idleOptions(givenOptions(pipeline), facts));
}

py::object RendererHandle::render(const VolumeHandle& volume, const py::object& progress,
                                  const py::kwargs& keywords) {
  const AskedPicture asked = askedPicture(keywords, volume.volume.get().info());
  Image image =
      drawn(asked, progress,
            [&](Renderer& renderer, const ProgressFunction& told, const std::stop_token& stop) {
              return renderer.draw(asked.picture, told, stop);
            });
  std::vector<uint8_t> bytes = [&] {
    const py::gil_scoped_release unlocked;
    return image.toRgba8(asked.background);
  }();
  py::array rgba = arrayOf(std::move(bytes), {image.height, image.width, 4});
  if (!asked.picture.with_depth) return rgba;
  return py::make_tuple(rgba, arrayOf(std::move(image.depth), {image.height, image.width}));
}

void RendererHandle::save(const VolumeHandle& volume, const std::string& path,
                          const py::object& progress, const py::kwargs& keywords) {
  const AskedPicture asked = askedPicture(keywords, volume.volume.get().info());
  drawn(asked, progress,
        [&](Renderer& renderer, const ProgressFunction& told, const std::stop_token& stop) {
          renderer.drawToFile(path, asked.picture, asked.background, told, stop);
          return true;
        });
}

py::object RendererHandle::probe(const VolumeHandle& volume, double right, double down,
                                 const py::kwargs& keywords) {
  const AskedPicture asked = askedPicture(keywords, volume.volume.get().info());
  const auto found =
      withLook(asked, py::none(), Use::kDrawn,
               [&](Renderer& renderer, const ProgressFunction&, const std::stop_token& stop) {
                 return renderer.probe(asked.picture, right, down, stop);
               });
  if (!found) return py::none();
  py::dict out;
  out["voxel"] = py::tuple(py::cast(found->voxel));
  out["world"] = py::tuple(py::cast(found->world));
  out["value"] = found->value;
  return out;
}

py::array RendererHandle::slice(int axis, int64_t at, int64_t time, int most) {
  Renderer& renderer = renderer_.get();
  SliceValues slice = run([&](const std::stop_token& stop) {
    return renderer.slice({.axis = axis, .at = at, .time = time, .most = most}, stop);
  });
  return arrayOf(std::move(slice.values), {slice.height, slice.width});
}

py::dict RendererHandle::plan(const VolumeHandle& volume, const py::object& progress,
                              const py::kwargs& keywords) {
  const AskedPicture asked = askedPicture(keywords, volume.volume.get().info());
  return planned(
      withLook(asked, progress, Use::kPlanned,
               [&](Renderer& renderer, const ProgressFunction& told, const std::stop_token& stop) {
                 return renderer.plan(asked.picture, told, stop);
               }));
}

py::dict RendererHandle::report() {
  const RenderReport report = renderer_.get().report();
  py::dict out;
  out["seconds"] = report.seconds;
  out["draw_seconds"] = report.draw_seconds;
  out["missing_share"] = report.missing_share;
  out["blocks"] = py::dict(py::arg("white") = report.white, py::arg("grey") = report.grey,
                           py::arg("black") = report.black);
  out["step"] = report.step_vox;
  out["levels"] = report.levels;
  out["coarse_share"] = report.coarse_share;
  out["will_improve"] = report.will_improve;
  out["why_empty"] = report.why_empty;
  out["empty_channels"] = report.empty_channels;
  out["read_bytes"] = report.read_bytes;
  out["volume_buffer"] = levelOf(report.volume_buffer);
  out["texture_buffer"] = levelOf(report.texture_buffer);
  out["texture_cache"] = levelOf(report.texture_cache);
  out["pages"] = report.pages;
  out["page_bytes"] = report.page_bytes;
  out["pages_loaded"] = report.pages_loaded;
  return out;
}

}  // namespace sluice::python

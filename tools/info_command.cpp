// sluice info: what a volume is, and its index, which is built where it is missing.
#include <fmt/format.h>

#include <memory>

#include "src/base/bytes.h"
#include "tools/commands.h"
#include "tools/options.h"
#include "tools/report.h"

namespace sluice {
namespace {

struct Arguments {
  VolumeArguments volume;
  ResourceArguments resources;
  bool json = false;
};

void print(const IndexedVolume& volume) {
  const VolumeLayout& layout = volume.source->layout();
  const ValueRange range = volume.valueRange();
  const auto voxels = static_cast<uint64_t>(layout.dims.x * layout.dims.y * layout.dims.z);
  fmt::print("{}\n", layout.name);
  fmt::print("  {} x {} x {} voxels, {}, {} a time step\n", layout.dims.x, layout.dims.y,
             layout.dims.z, name(layout.type), formatBytes(voxels * bytesPerVoxel(layout.type)));
  fmt::print("  spacing {} x {} x {}, {} time step{}\n", layout.spacing.x, layout.spacing.y,
             layout.spacing.z, layout.time_steps, layout.time_steps == 1 ? "" : "s");
  fmt::print("  values {} to {}\n", range.lo, range.hi);
  fmt::print("  {} blocks of {} a side, {} of them not all {}\n", volume.layout.blockCount(),
             volume.layout.size, volume.index.ranges.blocks.size(),
             volume.map.valueOf(volume.index.ranges.background));
  fmt::print("  index {}{}{}{}\n", volume.index.state, volume.index.path.empty() ? "" : ": ",
             volume.index.path.string(),
             volume.index.note.empty() ? "" : " (" + volume.index.note + ")");
}

}  // namespace

Command addInfo(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app =
      program.add_subcommand("info",
                             "What a volume is: size, type, value range, blocks, index\n\n"
                             "  sluice info head_256x256x225_uint8.raw --json");
  addVolumeOptions(*app, arguments->volume);
  addResourceOptions(*app, arguments->resources);
  app->add_flag("--json", arguments->json, "One JSON object");
  return [arguments] {
    WorkerPool pool(arguments->resources.threads);
    const IndexedVolume volume = openIndexed(arguments->volume, arguments->resources, false, pool);
    if (arguments->json) {
      fmt::print("{}\n", volumeJson(volume).dump(2));
    } else {
      print(volume);
    }
    return 0;
  };
}

}  // namespace sluice

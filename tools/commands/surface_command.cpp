// sluice surface: the surface of the voxels of at least a value, as a mesh.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "io/meshes/mesh_file.h"
#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/volume_surface.h"
#include "tools/command_line/console.h"
#include "tools/command_line/outputs.h"
#include "tools/command_line/progress_line.h"
#include "tools/commands/commands.h"
#include "tools/options/shared_options.h"
#include "tools/options/table_options.h"
#include "tools/outputs/report.h"
#include "tools/pages/report_file.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

struct SurfaceArguments {
  VolumeArguments volume;
  ResourceArguments resources;
  SurfaceOptions surface;
  std::string output, report_file;
  bool force = false;
  bool json = false;
};

MeshFormat formatOf(const std::string& output) {
  const auto format = meshFormat(output);
  if (!format) fail("-o {}: found no .ply, .stl or .obj at the end of the name", output);
  return *format;
}

nlohmann::json reportOf(const SurfaceArguments& arguments, const CLI::App& app,
                        const IndexedVolume& volume, const VolumeSurface& made,
                        double write_seconds) {
  const SurfaceReport& report = made.report;
  return {{"command", "surface"},
          {"options", optionsJson(app)},
          {"volume", volumeJson(volume)},
          {"output", arguments.output},
          {"threshold", arguments.surface.threshold},
          {"level", arguments.surface.level},
          {"level_dims", {made.dims.x, made.dims.y, made.dims.z}},
          {"vertices", report.vertices},
          {"triangles", report.triangles},
          {"blocks", {{"count", report.blocks}, {"read", report.blocks_read}}},
          {"voxel_bytes", report.voxel_bytes},
          {"warnings", made.warnings},
          {"seconds", {{"surface", report.seconds}, {"write", write_seconds}}},
          {"peak_rss_bytes", peakResidentBytes()}};
}

int run(SurfaceArguments& arguments, const CLI::App& app) {
  // The name is checked before the volume is opened, which may take minutes.
  const MeshFormat format = formatOf(arguments.output);
  Outputs outputs(arguments.force);
  outputs.reads(arguments.volume.inputs);
  outputs.writes("-o", arguments.output, kindOf(format));
  if (!arguments.report_file.empty())
    outputs.writes("--report", arguments.report_file, reportKind(arguments.report_file));
  Workers pool(arguments.resources.threads);
  const IndexedVolume volume = openIndexed(arguments.volume, arguments.resources,
                                           surfaceNeeds(arguments.surface), pool, outputs);
  MeshFile file(arguments.output, format,
                fmt::format("surface of {} at {:g}", volume.source->layout().name,
                            arguments.surface.threshold));
  VolumeSurface made;
  {
    ProgressMeter progress(arguments.resources.quiet ? ProgressWatch() : progressLine("surface"));
    made =
        makeSurface(volume, arguments.surface, file, passOf(pool, progress, arguments.resources));
  }
  // The bytes reach the disk here, which is a time of its own in the report.
  const Stopwatch watch;
  file.commit();
  const double write_seconds = watch.seconds();
  if (!arguments.resources.quiet)
    for (const std::string& warning : made.warnings) printWarning(warning);
  const nlohmann::json report = reportOf(arguments, app, volume, made, write_seconds);
  if (!arguments.report_file.empty()) writeReport(arguments.report_file, report);
  if (arguments.json) {
    sayJson(report);
  } else if (!arguments.resources.quiet) {
    say("{}\n  {} vertices, {} triangles, in {:.2f} s\n  {} of {} blocks read, {}\n",
        arguments.output, made.report.vertices, made.report.triangles,
        made.report.seconds + write_seconds, made.report.blocks_read, made.report.blocks,
        formatBytes(made.report.voxel_bytes));
  }
  return kDone;
}

}  // namespace

Command addSurface(CLI::App& program) {
  auto arguments = std::make_shared<SurfaceArguments>();
  CLI::App* app = program.add_subcommand(
      "surface",
      "Writes an isosurface as a mesh of triangles\n\n"
      "  sluice surface bonsai.nii.gz --iso 40 -o bonsai.ply\n\n"
      "The mesh has no cracks, even if it is larger than memory. Positions are in the world of\n"
      "the file's header. Triangles turn counterclockwise seen from the side of lower values, and\n"
      "normals point there.");
  addVolumeOptions(*app, arguments->volume);
  const OptionGroup surface(*app, "Surface");
  surface
      .number("--iso", "T", arguments->surface.threshold, {},
              "The value at the surface, as --threshold of render takes it")
      ->required()
      ->default_str("");
  surface.flag("--closed", arguments->surface.is_closed,
               "Closes the surface along the border of the volume or the crop");
  const auto asked = std::make_shared<ViewState>();
  const auto take = [arguments](const ViewState& state) {
    if (state.crop) {
      const auto& [lo, hi] = *state.crop;
      arguments->surface.crop = Box3{{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
    }
    arguments->surface.level = state.level.value_or(0);
  };
  const TableOptions table(*app, asked, take);
  table.add("--crop", "", "Surface");
  table.add("--level")->description("Level of resolution; 0 is the data as stored");
  addLevelsOption(OptionGroup(*app, std::string(kLevelsHeading)), arguments->resources);
  const OptionGroup output(*app, kOutputHeading);
  output
      .text("-o,--output", "FILE", arguments->output,
            "Mesh: .ply (binary) or .obj with normals of the gradient, or .stl (binary)")
      ->required();
  addReportOption(output, arguments->report_file);
  addForceOption(output, arguments->force);
  addQuietOption(output, arguments->resources.quiet);
  addJsonOption(output, arguments->json);
  const OptionGroup machine(*app, kMachineHeading);
  machine.bytes("--memory", arguments->resources.memory_bytes,
                "Budget for voxels and triangles (half of the machine's memory)");
  addThreadsOption(machine, arguments->resources.threads);
  addIndexDirOption(machine, arguments->resources.index_dir);
  return [arguments, app] { return run(*arguments, *app); };
}

}  // namespace sluice

// sluice synth: writes a synthetic volume of any size as a stream.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>
#include <memory>
#include <string>

#include "io/files/file_list.h"
#include "io/headers/raw/raw_name.h"
#include "io/headers/raw/raw_writer.h"
#include "io/headers/volume_description.h"
#include "io/synth/synth_source.h"
#include "src/base/error.h"
#include "src/base/files/numbered_name.h"
#include "src/base/threads/worker_pool.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/outputs.h"
#include "tools/command_line/parse.h"
#include "tools/command_line/progress_line.h"
#include "tools/commands/commands.h"
#include "tools/options/shared_options.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

struct SynthArguments {
  SynthOptions synth;
  std::string output;
  int threads = 0;
  bool force = false;
  bool quiet = false;
  bool json = false;
};

std::string kinds() {
  std::string text;
  for (const SynthKind kind : synthKinds())
    text += fmt::format("\n  {:<16}{}", name(kind), descriptionOf(kind));
  return text;
}

FileKind kindOf(const std::filesystem::path& file) {
  const std::string extension = lowerExtension(file);
  if (extension == ".nrrd" || extension == ".nhdr") return FileKind::kNrrd;
  return extension == ".mhd" ? FileKind::kMetaImage : FileKind::kRaw;
}

// Whether the name of a raw file describes all that is needed to read it.
bool describes(const std::filesystem::path& file, const VolumeLayout& layout) {
  const RawName said = parseRawName(file.filename().string());
  return said.dims == layout.dims && said.type == layout.type;
}

// A file whose name is wrong would be read as something else, without a word.
void requireTrueNames(const SynthArguments& arguments, const VolumeLayout& layout) {
  const Vec3i dims = layout.dims;
  for (const auto& file : filesToWrite(layout, arguments.output)) {
    if (lowerExtension(file) != ".raw") continue;
    const std::string wrong =
        falseInName(file.filename().string(), dims, layout.type, std::endian::native);
    if (!wrong.empty())
      fail(
          "{}: the name says {}, and the file would hold {} x {} x {} voxels, {}; give another "
          "name "
          "or other --dims and --type",
          file.string(), wrong, dims.x, dims.y, dims.z, name(layout.type));
  }
}

Outputs outputsOf(const SynthArguments& arguments, const VolumeLayout& layout) {
  Outputs outputs(arguments.force);
  for (const auto& file : filesToWrite(layout, arguments.output))
    outputs.writes("-o", file, kindOf(file));
  return outputs;
}

void run(const SynthArguments& arguments) {
  const auto source = openSynth(arguments.synth);
  const VolumeLayout& layout = source->layout();
  outputsOf(arguments, layout).check();
  requireTrueNames(arguments, layout);
  Workers pool(arguments.threads);
  const auto bytes = static_cast<uint64_t>(checkedVolumeBytes(arguments.output, layout));
  ProgressMeter progress = arguments.quiet
                               ? ProgressMeter()
                               : ProgressMeter(progressLine("writing " + arguments.output), bytes);
  const auto files =
      writeVolume(*source, arguments.output, {.stop = interruption()}, pool, progress);
  if (arguments.json) {
    nlohmann::json report{{"spec", specOf(arguments.synth)}, {"files", nlohmann::json::array()}};
    for (const auto& file : files) report["files"].push_back(file.string());
    sayJson(report);
  } else if (!arguments.quiet) {
    for (const auto& file : files) say("{}\n", file.string());
    const bool says_what_it_holds =
        lowerExtension(arguments.output) != ".raw" || describes(files.front(), layout);
    if (!says_what_it_holds)
      say("  to read it: --dims {},{},{} --type {}\n", layout.dims.x, layout.dims.y, layout.dims.z,
          name(layout.type));
  }
}

}  // namespace

Command addSynth(CLI::App& program) {
  auto arguments = std::make_shared<SynthArguments>();
  CLI::App* app = program.add_subcommand(
      "synth",
      "Writes a synthetic volume of any size\n\n"
      "  sluice synth phantom -o head_512x512x512_uint8.raw --dims 512,512,512\n\nKinds:" +
          kinds());
  const OptionGroup group(*app, "Volume");
  group
      .choice("kind", wordsOf<SynthKind>(synthKinds(), [](SynthKind kind) { return name(kind); }),
              arguments->synth.kind, "Kind of volume, see above")
      ->required()
      ->type_name("KIND");
  group.numbers(
      "--dims", "X,Y,Z", 3, {1, 1 << 20},
      [arguments](const std::vector<double>& n) {
        for (const double each : n)
          if (each != std::floor(each))
            throw CLI::ValidationError("--dims: expected whole numbers");
        arguments->synth.dims = asVec3i(n);
      },
      "Voxels along each axis", "256,256,256");
  addTypeOption(group, {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32}, arguments->synth.type,
                "Voxel type");
  group.number("--steps", "N", arguments->synth.time_steps, {1, 1'000'000},
               "Time steps (flow, mixing)");
  group.number("--seed", "N", arguments->synth.seed, {}, "Seed of everything random");
  group.number("--share", "SHARE", arguments->synth.object_share, {0, 1},
               "Share of non-zero voxels (slab, sparse, noise)");
  group.numbers(
      "--spacing", "X,Y,Z", 3, {0, 1e12, true},
      [arguments](const std::vector<double>& n) { arguments->synth.spacing = asVec3d(n); },
      "World units between voxels", "1,1,1");
  const OptionGroup output(*app, kOutputHeading);
  output
      .text("-o,--output", "FILE", arguments->output,
            "File: .raw (a name like head_256x256x225_uint8.raw describes the contents), .nrrd, "
            ".nhdr or .mhd; #### or %04d becomes the number of the step")
      ->required();
  addForceOption(output, arguments->force);
  addQuietOption(output, arguments->quiet);
  addJsonOption(output, arguments->json);
  addThreadsOption(OptionGroup(*app, kMachineHeading), arguments->threads);
  return [arguments] {
    run(*arguments);
    return 0;
  };
}

}  // namespace sluice

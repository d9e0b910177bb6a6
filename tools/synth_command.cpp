// sluice synth: writes a synthetic volume of any size as a stream.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <memory>
#include <string>

#include "io/raw_writer.h"
#include "io/synth_source.h"
#include "src/base/worker_pool.h"
#include "tools/commands.h"
#include "tools/options.h"
#include "tools/parse.h"

namespace sluice {
namespace {

struct Arguments {
  SynthOptions synth;
  std::string output;
  int threads = 0;
  bool json = false;
};

std::string kinds() {
  std::string text;
  for (const SynthKind kind : synthKinds())
    text += fmt::format("\n  {:<16}{}", name(kind), descriptionOf(kind));
  return text;
}

void run(const Arguments& arguments) {
  WorkerPool pool(arguments.threads);
  const auto source = openSynth(arguments.synth);
  const VolumeLayout& layout = source->layout();
  Progress progress(
      "writing " + arguments.output,
      static_cast<uint64_t>(volume(layout.dims) * layout.time_steps) * bytesPerVoxel(layout.type));
  const auto files =
      writeVolume(*source, arguments.output, {.describe_in_name = true}, pool, progress);
  if (arguments.json) {
    nlohmann::json report{{"spec", specOf(arguments.synth)}, {"files", nlohmann::json::array()}};
    for (const auto& file : files) report["files"].push_back(file.string());
    fmt::print("{}\n", report.dump(2));
  } else {
    for (const auto& file : files) fmt::print("{}\n", file.string());
  }
}

}  // namespace

Command addSynth(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app =
      program.add_subcommand("synth",
                             "Writes a synthetic volume of any size\n\n"
                             "  sluice synth phantom -o head.raw --dims 512,512,512\n\nKinds:" +
                                 kinds());
  addParsed(
      *app, "kind", "What to make", "KIND",
      [](const std::string& word) { return parseSynthKind(word); },
      [arguments](SynthKind kind) { arguments->synth.kind = kind; })
      ->required();
  app->add_option("-o,--output", arguments->output,
                  "File: .raw (size and type go into its name), .nrrd, .nhdr or .mhd")
      ->required()
      ->type_name("FILE");
  addParsed(
      *app, "--dims", "Voxels along each axis (256,256,256)", "X,Y,Z",
      [](const std::string& word) -> std::optional<Vec3i> {
        const auto n = parseNumbers(word, 3);
        if (!n) return std::nullopt;
        for (const double v : *n)
          if (v < 1 || v != std::floor(v)) return std::nullopt;
        return asVec3i(*n);
      },
      [arguments](Vec3i dims) { arguments->synth.dims = dims; });
  addParsed(
      *app, "--type", "Voxel type (u8)", "u8|u16|f32",
      [](const std::string& word) { return parseVoxelType(word); },
      [arguments](VoxelType type) { arguments->synth.type = type; });
  app->add_option("--steps", arguments->synth.time_steps, "Time steps (flow)")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app->add_option("--seed", arguments->synth.seed, "Of everything random")->capture_default_str();
  app->add_option("--share", arguments->synth.object_share,
                  "Share of non-zero voxels (slab, sparse, noise)")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.0));
  addParsed(
      *app, "--spacing", "World units between voxels (1,1,1)", "X,Y,Z",
      [](const std::string& word) { return parseNumbers(word, 3); },
      [arguments](const std::vector<double>& n) { arguments->synth.spacing = asVec3d(n); });
  app->add_option("--threads", arguments->threads, "Worker threads, 0 one a core")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  app->add_flag("--json", arguments->json, "One JSON object");
  return [arguments] {
    run(*arguments);
    return 0;
  };
}

}  // namespace sluice

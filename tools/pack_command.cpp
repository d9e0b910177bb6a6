// sluice pack: a volume as a store of compressed chunks, which others read too.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <memory>
#include <string>

#include "io/zarr_writer.h"
#include "src/base/bytes.h"
#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "tools/commands.h"
#include "tools/options.h"
#include "tools/scene.h"

namespace sluice {
namespace {

struct Arguments {
  VolumeArguments volume;
  ResourceArguments resources;
  PackOptions pack;
  std::string output;
  int level = 0;  // 0: the codec's own default
  bool check = false;
  bool json = false;
};

constexpr int kLz4Level = 5, kZstdLevel = 1, kInterrupted = 130;

// The index that the store's first opening would build: of every time step.
IndexedRanges indexStore(const Arguments& arguments, WorkerPool& pool) {
  VolumeArguments store;
  store.inputs = {arguments.output};
  IndexedVolume volume = openIndexed(store, arguments.resources, false, pool);
  for (int64_t t = 1; t < volume.source->layout().time_steps; ++t)
    indexedRanges(*volume.source, arguments.output, t, volume.layout, pool);
  return std::move(volume.index);
}

int pack(const Arguments& arguments) {
  WorkerPool pool(arguments.resources.threads);
  const auto source = openVolume(arguments.volume.inputs, arguments.volume.open);
  const VolumeLayout& layout = source->layout();
  PackOptions options = arguments.pack;
  options.memory_bytes = memoryBudget(arguments.resources);
  options.blosc.level = arguments.level != 0                      ? arguments.level
                        : options.blosc.codec == BloscCodec::kLz4 ? kLz4Level
                                                                  : kZstdLevel;
  PackReport report;
  try {
    Progress progress("packing", static_cast<uint64_t>(volume(layout.dims) * layout.time_steps) *
                                     bytesPerVoxel(layout.type) * (options.verify ? 2 : 1));
    report = packZarr(*source, arguments.output, options, pool, progress);
  } catch (const Interrupted&) {
    fmt::print(stderr, "sluice: interrupted; the same command goes on where this one ended\n");
    return kInterrupted;
  }
  const Stopwatch watch;
  const IndexedRanges index = indexStore(arguments, pool);
  const double index_seconds = watch.seconds();
  const double ratio = static_cast<double>(report.voxel_bytes) /
                       static_cast<double>(std::max<uint64_t>(1, report.stored_bytes));
  if (arguments.json) {
    const nlohmann::json json{
        {"output", arguments.output},
        {"chunks",
         {{"count", report.chunks}, {"empty", report.empty_chunks}, {"kept", report.kept_chunks}}},
        {"voxel_bytes", report.voxel_bytes},
        {"stored_bytes", report.stored_bytes},
        {"ratio", ratio},
        {"verified", options.verify},
        {"seconds",
         {{"pack", report.pack_seconds},
          {"verify", report.verify_seconds},
          {"index", index_seconds}}},
        {"index", {{"path", index.path.string()}, {"state", index.state}}},
        {"peak_rss_bytes", peakResidentBytes()}};
    fmt::print("{}\n", json.dump(2));
    return 0;
  }
  fmt::print("{}\n", arguments.output);
  fmt::print("  {} chunks, {} of them empty{}{}\n", report.chunks, report.empty_chunks,
             report.kept_chunks == 0
                 ? ""
                 : fmt::format(", {} done before an interruption", report.kept_chunks),
             options.verify ? ", all equal to the volume" : "");
  fmt::print("  {} as {}: {:.2f} to 1, in {:.1f} s\n", formatBytes(report.voxel_bytes),
             formatBytes(report.stored_bytes), ratio, report.pack_seconds + report.verify_seconds);
  fmt::print("  index {}{}{}{}\n", index.state, index.path.empty() ? "" : ": ", index.path.string(),
             index.note.empty() ? "" : " (" + index.note + ")");
  return 0;
}

int check(const Arguments& arguments) {
  WorkerPool pool(arguments.resources.threads);
  const std::string& name = arguments.volume.inputs.front();
  CheckReport report;
  {
    Progress progress("checking " + name);
    report = checkZarr(name, pool, progress);
  }
  if (arguments.json) {
    const nlohmann::json json{{"chunks", report.chunks},
                              {"stored_bytes", report.stored_bytes},
                              {"faults", report.faults}};
    fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  if (!report.faults.empty())
    fail("{} of {} chunks are not as packed: {}", report.faults.size(), report.chunks,
         report.faults.front());
  if (!arguments.json)
    fmt::print("{}: {} chunks, {}, all as packed\n", name, report.chunks,
               formatBytes(report.stored_bytes));
  return 0;
}

}  // namespace

Command addPack(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand(
      "pack",
      "Writes a volume as an OME-Zarr store of compressed chunks\n\n"
      "  sluice pack head_256x256x225_uint8.raw -o head.zarr --codec zstd\n"
      "  sluice pack --check head.zarr\n\n"
      "Interrupted in any way, the same command goes on where the first one ended: until all is\n"
      "written the store is called DIR.zarr.partial. Each chunk has a checksum, which is compared\n"
      "whenever sluice reads it.");
  addVolumeOptions(*app, arguments->volume);
  app->remove_option(app->get_option("--time"));  // all of them are packed
  CLI::Option* output = app->add_option("-o,--output", arguments->output, "The store, NAME.zarr")
                            ->type_name("DIR.zarr");
  app->add_option("--chunk", arguments->pack.chunk_voxels, "Voxels a side of a chunk")
      ->capture_default_str()
      ->check(CLI::Range(4, 1024))
      ->type_name("N");
  addParsed(
      *app, "--codec", "Inside Blosc: lz4 is read faster, zstd is smaller (lz4)", "lz4|zstd",
      [](const std::string& word) -> std::optional<BloscCodec> {
        if (word == "lz4") return BloscCodec::kLz4;
        if (word == "zstd") return BloscCodec::kZstd;
        return std::nullopt;
      },
      [arguments](BloscCodec codec) { arguments->pack.blosc.codec = codec; });
  app->add_option(
         "--level", arguments->level,
         fmt::format("How hard the codec tries ({} for lz4, {} for zstd)", kLz4Level, kZstdLevel))
      ->check(CLI::Range(1, 9))
      ->type_name("1..9");
  app->add_option("--unit", arguments->pack.unit,
                  "Of the spacing, where the file does not say it: micrometer, millimeter, ...")
      ->type_name("NAME");
  addParsed(*app, "--memory", "Budget of the voxels and chunks held (half the machine's)", "BYTES",
            parseBytes, [arguments](uint64_t bytes) { arguments->resources.memory_bytes = bytes; });
  app->add_option("--threads", arguments->resources.threads, "Worker threads, 0 one a core")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  CLI::Option* verify = app->add_flag("--verify", arguments->pack.verify,
                                      "Reads the store again and compares every voxel");
  CLI::Option* force = app->add_flag("--force", arguments->pack.replace,
                                     "Replaces an existing store, once the new one is whole");
  app->add_flag("--check", arguments->check,
                "VOLUME is a packed store: compares every chunk with its checksum")
      ->excludes(output)
      ->excludes(verify)
      ->excludes(force);
  app->add_flag("--json", arguments->json, "One JSON object");
  app->parse_complete_callback([arguments] {
    if (!arguments->check && arguments->output.empty()) throw CLI::RequiredError("--output");
  });
  return [arguments] { return arguments->check ? check(*arguments) : pack(*arguments); };
}

}  // namespace sluice

// sluice pack: a volume as a store of compressed chunks, which others read too.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "io/files/length_unit.h"
#include "io/zarr/packing/zarr_writer.h"
#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/index/index_file.h"
#include "src/library/opening/step_ranges.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/number.h"
#include "tools/command_line/outputs.h"
#include "tools/command_line/parse.h"
#include "tools/command_line/progress_line.h"
#include "tools/command_line/usage.h"
#include "tools/commands/commands.h"
#include "tools/options/shared_options.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

struct PackArguments {
  VolumeArguments volume;
  ResourceArguments resources;
  PackOptions pack;
  std::string output;
  int level = 0;  // 0: the codec's own default
  int zarr = 2;
  std::optional<Vec3i> shard = {};
  bool check = false;
  bool json = false;
};

struct PackedLevels {
  bool any = false;
  std::optional<int64_t> count;
};
constexpr int64_t kMostLevels = 30;

// "auto", "none" or how many.
std::optional<PackedLevels> levelsWish(const std::string& word) {
  if (word == "none") return PackedLevels{};
  if (word == "auto") return PackedLevels{true, std::nullopt};
  const auto count = parseIn<int64_t>(word, {1, kMostLevels});
  return count ? std::optional(PackedLevels{true, *count}) : std::nullopt;
}

// "256" or "256,256,64".
std::optional<Vec3i> shards(const std::string& word) {
  constexpr int64_t kMostVoxels = int64_t{1} << 30;
  if (const auto side = parseIn<int64_t>(word, {1, kMostVoxels})) return Vec3i{*side, *side, *side};
  const auto numbers = parseNumbers(word, 3);
  if (!numbers) return std::nullopt;
  for (const double n : *numbers)
    if (n != std::floor(n) || n < 1 || n > double{kMostVoxels}) return std::nullopt;
  return asVec3i(*numbers);
}

// Each way once, means first: other programs know them best.
std::vector<Downsample> inOrder(const std::vector<Downsample>& ways) {
  std::vector<Downsample> ordered;
  for (const Downsample how : ways)
    if (std::ranges::find(ordered, how) == ordered.end())
      ordered.insert(how == Downsample::kMean ? ordered.begin() : ordered.end(), how);
  return ordered;
}

constexpr int kLz4Level = 5, kZstdLevel = 1;

// The indices that the store's first openings would build: of every channel and time step. Returns
// the first.
std::shared_ptr<const IndexedRanges> indexStore(const PackArguments& arguments, size_t channels,
                                                WorkerPool& pool) {
  ProgressMeter progress;
  VolumeArguments store;
  store.inputs = {arguments.output};
  ResourceArguments resources = arguments.resources;
  resources.levels = LevelsWish::kKept;  // the store has the levels that were asked for
  std::shared_ptr<const IndexedRanges> first;
  std::vector<std::string> said;
  for (size_t c = 0; c < channels; ++c) {
    if (channels > 1) store.open.channel = static_cast<int64_t>(c);
    IndexedVolume volume = openIndexed(store, resources, kUsualNeeds, pool, said);
    // The first step was indexed when the store was opened.
    for (int64_t t = 1; t < volume.source->layout().time_steps; ++t)
      rangesOfStep(volume, t, passOf(pool, progress, arguments.resources));
    if (c == 0) first = volume.index;
  }
  return first;
}

// Removes the indices of a store that had this name before, replaced or deleted, which would only
// be found stale.
void removeOldIndices(const PackArguments& arguments) {
  const IndexPlaces places =
      indexPlaces(arguments.output, indexWish(arguments.resources.index_dir));
  for (const std::filesystem::path& folder : places.folders) removeIndices(folder);
}

// Says that programs which do not know the scaling of the values show other numbers.
void noteScale(const VolumeLayout& layout, const std::string& output) {
  if (layout.value_scale == 1 && layout.value_offset == 0) return;
  printNotice(fmt::format(
      "{}: holds the stored numbers; values are these * {:g} + {:g}, as sluice and xarray read "
      "them (scale_factor, add_offset). Other programs show the stored numbers",
      output, layout.value_scale, layout.value_offset));
}

// Says that programs which read OME-Zarr may not know the unit of the spacing.
void noteUnit(const std::string& unit, const std::string& output) {
  if (unit.empty() || isNgffUnit(unit)) return;
  printWarning(fmt::format(
      "{}: its spacing has the unit \"{}\", which is none of OME-Zarr's; give --unit micrometer, "
      "millimeter, nanometer or another one",
      output, unit));
}

// Says once what is worth knowing of the channels' source, which the store will not tell.
void printNotes(std::span<const std::unique_ptr<VolumeSource>> channels) {
  // The first of several was opened without a choice, and a note of its own says so.
  if (channels.size() > 1) channels = channels.subspan(1);
  std::vector<std::string> said;
  for (const auto& channel : channels) printNewWarnings(channel->layout().notes, said);
}

// A source for each channel; the one that the user asks for alone.
std::vector<std::unique_ptr<VolumeSource>> openEachChannel(const VolumeArguments& arguments) {
  std::vector<std::unique_ptr<VolumeSource>> channels;
  channels.push_back(openVolume(arguments.inputs, arguments.open));
  const int64_t count = arguments.open.channel.given() ? 1 : channels[0]->layout().channels;
  for (int64_t c = 1; c < count; ++c) {
    OpenOptions open = arguments.open;
    open.channel = c;
    channels.push_back(openVolume(arguments.inputs, open));
  }
  return channels;
}

// The wanted side, or less if one chunk holds the volume anyway: chunks are filled up to their
// side, which takes seconds and gigabytes at 1024 voxels.
int64_t chunkSide(const PackArguments& arguments, Vec3i dims) {
  const int64_t wanted = arguments.pack.chunk_voxels;
  const auto longest = static_cast<uint64_t>(std::max({dims.x, dims.y, dims.z}));
  // The sides of shards count in wanted chunks.
  if (arguments.shard || longest > static_cast<uint64_t>(wanted)) return wanted;
  return std::min(wanted, std::max(int64_t{64}, static_cast<int64_t>(std::bit_ceil(longest))));
}

// The wanted one, or about 512 voxels a side: a volume of 2048 a side is 64 files.
Vec3i shardOf(const PackArguments& arguments, int64_t chunk) {
  constexpr int64_t kUsualSide = 512;
  const int64_t side = std::max<int64_t>(kUsualSide / chunk, 1) * chunk;
  return arguments.shard.value_or(Vec3i{side, side, side});
}

// The options as given, completed from the volume and the machine.
PackOptions packOptions(const PackArguments& arguments, Vec3i dims) {
  PackOptions options = arguments.pack;
  options.downsample = inOrder(options.downsample);
  options.stop = interruption();
  options.chunk_voxels = chunkSide(arguments, dims);
  if (arguments.zarr == 3) options.shard_voxels = shardOf(arguments, options.chunk_voxels);
  options.memory_bytes = memoryBudget(arguments.resources);
  options.blosc.level = arguments.level != 0                      ? arguments.level
                        : options.blosc.codec == BloscCodec::kLz4 ? kLz4Level
                                                                  : kZstdLevel;
  return options;
}

struct Packed {
  PackReport store = {};
  size_t channels = 0;
  bool is_verified = false;
  std::shared_ptr<const IndexedRanges> index = {};
  double index_seconds = 0;

  double ratio() const {
    return static_cast<double>(store.voxel_bytes) /
           static_cast<double>(std::max<uint64_t>(1, store.stored_bytes));
  }
};

void sayPackedJson(const Packed& packed, const std::string& output) {
  const PackReport& report = packed.store;
  const IndexedRanges& index = *packed.index;
  const nlohmann::json json{
      {"output", output},
      {"chunks",
       {{"count", report.chunks}, {"empty", report.empty_chunks}, {"kept", report.kept_chunks}}},
      {"files", report.files},
      {"channels", packed.channels},
      {"levels", 1 + report.levels.size()},
      {"voxel_bytes", report.voxel_bytes},
      {"stored_bytes", report.stored_bytes},
      {"ratio", packed.ratio()},
      {"verified", packed.is_verified},
      {"seconds",
       {{"pack", report.pack_seconds},
        {"verify", report.verify_seconds},
        {"index", packed.index_seconds}}},
      {"index", {{"path", index.path.string()}, {"state", name(index.origin)}}},
      {"peak_rss_bytes", peakResidentBytes()}};
  sayJson(json);
}

void sayPacked(const Packed& packed, const std::string& output) {
  const PackReport& report = packed.store;
  const IndexedRanges& index = *packed.index;
  say("{}\n", output);
  if (packed.channels > 1) say("  {} channels\n", packed.channels);
  for (size_t i = 0; i < report.levels.size(); ++i) {
    const Vec3i dims = report.levels[i];
    say("  level {}: {} x {} x {} voxels\n", i + 1, dims.x, dims.y, dims.z);
  }
  say("  {} chunks, {} of them empty, in {} files{}{}\n", report.chunks, report.empty_chunks,
      report.files,
      report.kept_chunks == 0 ? ""
                              : fmt::format(", {} done before an interruption", report.kept_chunks),
      packed.is_verified ? ", all equal to the volume" : "");
  say("  {} as {}: {:.2f} to 1, in {:.1f} s\n", formatBytes(report.voxel_bytes),
      formatBytes(report.stored_bytes), packed.ratio(),
      report.pack_seconds + report.verify_seconds);
  say("  index {}{}{}{}\n", name(index.origin), index.path.empty() ? "" : ": ", index.path.string(),
      index.note.empty() ? "" : " (" + index.note + ")");
}

int pack(const PackArguments& arguments) {
  if (arguments.zarr == 2 && arguments.shard)
    failUsage("--shard: Zarr 2 has no shards, expected --zarr 3 with it");
  Outputs outputs;
  outputs.reads(arguments.volume.inputs);
  outputs.writesFolder("-o", arguments.output);
  // This comes before anything is opened: an output that holds an input is found by its name alone.
  outputs.checkNames();
  const auto sources = openEachChannel(arguments.volume);
  if (!arguments.resources.quiet) {
    printNotes(sources);
    const VolumeLayout& layout = sources.front()->layout();
    noteScale(layout, arguments.output);
    noteUnit(arguments.pack.unit.empty() ? layout.unit : lengthUnit(arguments.pack.unit),
             arguments.output);
  }
  std::vector<VolumeSource*> channels;
  channels.reserve(sources.size());
  for (const auto& source : sources) channels.push_back(source.get());
  // The other files of a series are known only now.
  outputs.check(channels.front()->files());
  Workers pool(arguments.resources.threads);
  const PackOptions options = packOptions(arguments, channels.front()->layout().dims);
  const uint64_t bytes = packedBytes(channels) * (options.verify ? 2 : 1);
  Packed packed{.channels = channels.size(), .is_verified = options.verify};
  {
    ProgressMeter progress =
        arguments.resources.quiet ? ProgressMeter() : ProgressMeter(progressLine("packing"), bytes);
    sayWhenInterrupted("interrupted; run the same command again to continue");
    packed.store = packZarr(channels, arguments.output, options, pool, progress);
    // The store is whole, its index may not be.
    sayWhenInterrupted("interrupted; the store is complete, and its first use makes its index");
  }
  removeOldIndices(arguments);
  const Stopwatch watch;
  packed.index = indexStore(arguments, channels.size(), pool);
  packed.index_seconds = watch.seconds();
  if (arguments.json)
    sayPackedJson(packed, arguments.output);
  else if (!arguments.resources.quiet)
    sayPacked(packed, arguments.output);
  return kDone;
}

int check(const PackArguments& arguments) {
  Workers pool(arguments.resources.threads);
  const std::string& name = arguments.volume.inputs.front();
  std::error_code unknown;
  if (!std::filesystem::exists(name, unknown))
    fail("{}: expected a store that sluice pack has written, found no such file or folder", name);
  CheckReport report;
  {
    ProgressMeter progress = arguments.resources.quiet
                                 ? ProgressMeter()
                                 : ProgressMeter(progressLine("checking " + name));
    report = checkZarr(name, pool, progress, interruption());
  }
  if (arguments.json) {
    const nlohmann::json json{{"chunks", report.chunks},
                              {"stored_bytes", report.stored_bytes},
                              {"faults", report.faults}};
    sayJson(json);
  }
  // The report comes first, so that --json lists all of them; the exit status tells as well.
  if (!report.faults.empty())
    fail("{} of {} chunks are not as packed: {}", report.faults.size(), report.chunks,
         report.faults.front());
  if (!arguments.json && !arguments.resources.quiet)
    say("{}: {} chunks, {}, all as packed\n", name, report.chunks,
        formatBytes(report.stored_bytes));
  return 0;
}

}  // namespace

Command addPack(CLI::App& program) {
  auto arguments = std::make_shared<PackArguments>();
  CLI::App* app = program.add_subcommand(
      "pack",
      "Writes a volume as an OME-Zarr store of compressed chunks\n\n"
      "  sluice pack head_256x256x225_uint8.raw -o head.zarr --codec zstd\n"
      "  sluice pack --check head.zarr\n\n"
      "If a run is interrupted, give the same command again: it continues where the run stopped.\n"
      "Until the store is complete, it is called DIR.zarr.partial. Each chunk has a checksum,\n"
      "which sluice compares whenever it reads the chunk. Voxels are stored as they are: a factor\n"
      "and an offset that lead to their values go with them (scale_factor, add_offset).");
  addVolumeOptions(*app, arguments->volume);
  app->remove_option(app->get_option("--time"));  // all of them are packed
  const OptionGroup store(*app, "Store");
  CLI::Option* output =
      store.text("-o,--output", "DIR.zarr", arguments->output, "The store, NAME.zarr");
  store.number("--chunk", "N", arguments->pack.chunk_voxels, {4, 1024},
               "Voxels per side of a chunk; fewer for a volume that is smaller");
  store.choice("--zarr", Words<int>{{"2", 2}, {"3", 3}}, arguments->zarr,
               "Version of Zarr: 2 (OME-Zarr 0.4), or 3 (OME-Zarr 0.5), which has shards");
  store.parsed(
      "--shard", "X,Y,Z", "one number or X,Y,Z, multiples of --chunk", shards,
      [arguments](const Vec3i& voxels) { arguments->shard = voxels; },
      "Zarr 3: voxels of a file along each axis, multiples of --chunk (about 512)");
  store.choice("--codec", Words<BloscCodec>{{"lz4", BloscCodec::kLz4}, {"zstd", BloscCodec::kZstd}},
               arguments->pack.blosc.codec,
               "Codec inside Blosc: lz4 reads faster, zstd is smaller");
  store
      .number("--level", "1..9", arguments->level, {1, 9},
              fmt::format("Compression level of the codec ({} for lz4, {} for zstd)", kLz4Level,
                          kZstdLevel))
      ->default_str("");
  PackOptions& options = arguments->pack;
  store.parsed(
      "--levels", "auto|N|none", fmt::format("auto, none or a number from 1 to {}", kMostLevels),
      levelsWish,
      [&options](const PackedLevels& wish) {
        options.with_levels = wish.any;
        options.levels = wish.count;
      },
      "Also writes coarser levels of resolution: N of them, or (auto) down to 64 voxels per side",
      "none");
  store
      .choices("--downsample",
               Words<Downsample>{{"mean", Downsample::kMean},
                                 {"max", Downsample::kMax},
                                 {"min", Downsample::kMin},
                                 {"mode", Downsample::kMode}},
               options.downsample,
               "How a voxel of a coarser level follows from finer ones: mean, max for --mode mip, "
               "min for minip, mode for labels. Several, as mean,max, make levels of each kind")
      ->default_str("mean");
  store.text(
      "--unit", "NAME", arguments->pack.unit,
      "Unit of the spacing, if the file does not name it: micrometer or um, millimeter, ...");
  CLI::Option* verify = store.flag("--verify", arguments->pack.verify,
                                   "Reads the store again and compares every voxel");
  CLI::Option* force = store.flag("--force", arguments->pack.replace,
                                  "Replaces an existing store once the new one is complete");
  store
      .flag("--check", arguments->check,
            "VOLUME is a packed store: compares every chunk with its checksum")
      ->excludes(output)
      ->excludes(verify)
      ->excludes(force);
  const OptionGroup printed(*app, kOutputHeading);
  addQuietOption(printed, arguments->resources.quiet);
  addJsonOption(printed, arguments->json);
  const OptionGroup machine(*app, kMachineHeading);
  machine.bytes("--memory", arguments->resources.memory_bytes,
                "Budget for voxels and chunks (half of the machine's memory)");
  addThreadsOption(machine, arguments->resources.threads);
  addIndexDirOption(machine, arguments->resources.index_dir);
  // --check needs no output, so that the parser cannot require one.
  app->parse_complete_callback([arguments] {
    if (!arguments->check && arguments->output.empty()) throw CLI::RequiredError("--output");
  });
  return [arguments] { return arguments->check ? check(*arguments) : pack(*arguments); };
}

}  // namespace sluice

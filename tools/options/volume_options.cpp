#include <algorithm>
#include <atomic>
#include <bit>
#include <memory>

#include "io/headers/volume_description.h"
#include "src/base/values/bytes.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/parse.h"
#include "tools/options/shared_options.h"

namespace sluice {
namespace {

constexpr double kMostSpacing = 1e12;
constexpr int64_t kMostSteps = 1'000'000'000;

std::optional<std::vector<double>> dimensions(const std::string& word) {
  auto found = parseNumbers(word, 3);
  if (!found) found = parseNumbers(word, 4);
  if (!found) return std::nullopt;
  for (const double n : *found)
    if (n < 1 || n > kMostVoxels || n != static_cast<double>(static_cast<int64_t>(n)))
      return std::nullopt;
  return found;
}

// Parses one spacing for all axes, or one each.
std::optional<std::vector<double>> spacings(const std::string& word) {
  auto found = parseNumbers(word, 3);
  if (!found) {
    const auto one = parseNumbers(word, 1);
    if (!one) return std::nullopt;
    found = std::vector<double>(3, one->front());
  }
  for (const double n : *found)
    if (!(n > 0 && n <= kMostSpacing)) return std::nullopt;
  return found;
}

// A word of digits is a number, whatever the channels are called.
std::optional<ChannelWish> channel(const std::string& word) {
  if (word.empty()) return std::nullopt;
  if (word.find_first_not_of("+-0123456789") != std::string::npos)
    return ChannelWish(std::nullopt, word);
  const auto number = parseIn<int64_t>(word, {0, 1'000'000});
  return number ? std::optional(ChannelWish(*number)) : std::nullopt;
}

// "5", "0:63" or "0:63:4", the last one included.
std::optional<TimeRange> timeRange(const std::string& word) {
  std::vector<int64_t> numbers;
  for (size_t at = 0; at <= word.size();) {
    const size_t end = std::min(word.find(':', at), word.size());
    const auto number = parseIn<int64_t>(word.substr(at, end - at), {0, kMostSteps});
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    at = end + 1;
  }
  if (numbers.empty() || numbers.size() > 3) return std::nullopt;
  TimeRange range{numbers.front(), numbers.size() > 1 ? numbers[1] : numbers.front(),
                  numbers.size() > 2 ? numbers[2] : 1};
  if (range.last < range.first || range.stride < 1) return std::nullopt;
  return range;
}

constexpr uint64_t kCacheBytes = uint64_t{20} << 30;

// Prints the first of the warnings about the cache: several volumes may share it.
std::function<void(const std::string&)> warnOnce(const CLI::App& app) {
  return [&app, has_warned = std::make_shared<std::atomic_flag>()](const std::string& line) {
    const CLI::Option* const quiet = app.get_option_no_throw("--quiet");
    const bool is_quiet = quiet != nullptr && quiet->count() > 0;
    if (!has_warned->test_and_set() && !is_quiet) printWarning(line);
  };
}

// Each of the two turns the cache on.
void addWebCacheOptions(const OptionGroup& group, WebCache& cache) {
  const auto positive = [](const std::string& word) {
    const auto bytes = parseBytes(word);
    return bytes && *bytes > 0 ? bytes : std::nullopt;
  };
  group.rare().parsed(
      "--cache", "BYTES", "a size above 0 and below 8 EiB, as in 512M or 20G", positive,
      [&cache](uint64_t bytes) {
        cache.budget_bytes = bytes;
        if (cache.folder.empty()) cache.folder = webCacheFolder();
      },
      "Keeps the data read from servers in a folder of at most this many bytes");
  group.rare().parsed(
      "--cache-dir", "DIR", "the name of a folder",
      [](const std::string& word) { return word.empty() ? std::nullopt : std::optional(word); },
      [&cache](const std::string& folder) {
        cache.folder = folder;
        if (cache.budget_bytes == 0) cache.budget_bytes = kCacheBytes;
      },
      "The folder of --cache (in the user's cache folder); without --cache the limit is 20G");
}

}  // namespace

void addVolumeOptions(CLI::App& app, VolumeArguments& arguments, std::optional<TimeRange>* times,
                      bool needs_volume) {
  arguments.open.decode = decodeOptions();
  arguments.open.stop = interruption();
  arguments.open.web.find_buckets = [] { return bucketAccess(); };
  arguments.open.web.certificates = webCertificates();
  arguments.open.web.warn = warnOnce(app);
  requireNames(
      app.add_option(
          "volume", arguments.inputs,
          "Files (FILE.h5:/SET), a folder of slices or DICOM images, a Zarr or N5 store, "
          "zipped or not, or its "
          "address (https://..., s3://...), a pattern ('step_%03d.raw', 'step_###.raw'), or "
          "synth:KIND,..."))
      ->required(needs_volume)
      ->type_name("VOLUME")
      ->group("Volume");
  const OptionGroup group(app, "Volume");
  group.parsed(
      "--dims", "X,Y,Z[,T]", "whole numbers X,Y,Z or X,Y,Z,T, each from 1 to 2^40", dimensions,
      [&arguments](const std::vector<double>& n) {
        arguments.open.dims = asVec3i(n);
        if (n.size() == 4) arguments.open.time_steps = static_cast<int64_t>(n[3]);
      },
      "Raw: voxels along each axis, and time steps");
  addTypeOption(group,
                {VoxelType::kU8, VoxelType::kI8, VoxelType::kU16, VoxelType::kI16, VoxelType::kU32,
                 VoxelType::kI32, VoxelType::kF32, VoxelType::kF64},
                arguments.open.type, "Raw: voxel type");
  group.rare().choice(
      "--endian", Words<std::endian>{{"little", std::endian::little}, {"big", std::endian::big}},
      arguments.open.byte_order, "Raw: byte order");
  group.rare().number("--skip", "BYTES", arguments.open.skip_bytes, {0, kMostSkipBytes},
                      "Raw: bytes before the voxels");
  group.parsed(
      "--spacing", "X,Y,Z", "one number or X,Y,Z, each above 0, up to 1e+12", spacings,
      [&arguments](const std::vector<double>& n) { arguments.open.spacing = asVec3d(n); },
      "World units between voxels, instead of the file's");
  group.rare().text("--grid", "NAME", arguments.open.grid,
                    "OpenVDB: name of the grid; DICOM: number of the series");
  group.parsed(
      "--channel", "N|NAME,...", "a channel's number from 0 to 1000000, or its name", channel,
      [&arguments](const ChannelWish& wish) { arguments.open.channel = wish; },
      "Zarr, N5, HDF5, VTK, TIFF: channel by its number, from 0 (the first), or by its name in the "
      "file; pictures show several together (the active ones of an OME file, else the first)");
  addWebCacheOptions(group, arguments.open.web.cache);
  if (times == nullptr) {
    group.number("--time", "STEP", arguments.time, {0, kMostSteps}, "Time step, from 0");
    return;
  }
  group.parsed(
      "--time", "STEP|A:B[:S]", "a time step from 0, or A:B or A:B:S with A <= B", timeRange,
      [&arguments, times](const TimeRange& range) {
        arguments.time = range.first;
        if (range.count() > 1) *times = range;
      },
      "Time step, from 0; or the steps A, A + S, ... up to B", "0");
}

void addOverOption(CLI::App& app, VolumeArguments& arguments) {
  const OptionGroup group(app, "Volume");
  group.text("--over", "SECOND", arguments.over,
             "A second volume, drawn together with the first at its own place in the world, such "
             "as labels over a scan; --look over:... gives its look");
}

}  // namespace sluice

#include <algorithm>
#include <atomic>
#include <bit>
#include <memory>

#include "src/base/values/bytes.h"
#include "src/library/conversions.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/parse.h"
#include "tools/options/shared_options.h"

namespace sluice {
namespace {

constexpr int64_t kMostSteps = 1'000'000'000;

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

TableOptionsOf<VolumeOptions> tableFor(CLI::App& app, VolumeArguments& arguments) {
  // The caller keeps the arguments.
  const std::shared_ptr<VolumeOptions> asked(std::shared_ptr<void>(), &arguments.asked);
  return {app, asked, [&app, &arguments](const VolumeOptions& options) {
            setOpen(arguments);
            // Files other than raw ones refuse any byte order, even the usual one.
            if (app.count("--endian") > 0 && !options.big_endian)
              arguments.open.byte_order = std::endian::little;
          }};
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
      ->group(std::string(kVolumeHeading));
  tableFor(app, arguments).addRest(kVolumeHeading, OptionPart::kVolume);
  const OptionGroup group(app, std::string(kVolumeHeading));
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
  tableFor(app, arguments).add("--over", "", std::string(kVolumeHeading));
}

}  // namespace sluice

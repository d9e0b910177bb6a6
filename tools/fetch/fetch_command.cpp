// sluice fetch: copies public volumes to this machine, with their licence first.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <bit>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "io/fetch_volume.h"
#include "io/headers/raw/raw_name.h"
#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/near_miss.h"
#include "tools/command_line/progress_line.h"
#include "tools/commands/commands.h"
#include "tools/fetch/named_volumes.h"
#include "tools/options/shared_options.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

struct FetchArguments {
  std::string what;  // a name or an address
  std::string output;
  std::string sha256;
  bool accepts = false, lists = false, force = false, quiet = false, json = false;
};

// A volume that is to be fetched.
struct Wanted {
  const NamedVolume* named = nullptr;  // null: an address
  std::string address, shown_address;  // as it is asked for, and as it is printed
  fs::path target;
  ExpectedObject expected = {};
};

Wanted wantedBy(const FetchArguments& arguments) {
  Wanted wanted;
  wanted.expected.sha256 = arguments.sha256;
  if (isAddress(arguments.what)) {
    const BucketAccess access = isBucketAddress(arguments.what) ? bucketAccess() : BucketAccess{};
    const Address address = parseAddress(arguments.what, access);
    wanted.address = arguments.what;
    wanted.shown_address = printedAddress(address);
    wanted.target = address.key.substr(address.key.rfind('/') + 1);
  } else {
    wanted.named = findVolume(arguments.what);
    if (wanted.named == nullptr) {
      std::vector<std::string> names;
      for (const NamedVolume& volume : namedVolumes()) names.emplace_back(volume.name);
      const std::string meant = nearest(arguments.what, names);
      fail("{}: no volume of that name{}; sluice fetch --list prints those that are known",
           arguments.what, meant.empty() ? "" : fmt::format(", did you mean {}?", meant));
    }
    wanted.address = wanted.shown_address = wanted.named->address();
    wanted.target = wanted.named->file();
    wanted.expected.bytes = wanted.named->bytes();
    if (wanted.expected.sha256.empty()) wanted.expected.sha256 = wanted.named->sha256;
  }
  if (!arguments.output.empty()) wanted.target = arguments.output;
  // Shells end the name of a folder by a slash.
  if (!wanted.target.has_filename()) wanted.target = wanted.target.parent_path();
  return wanted;
}

// The file of a named volume holds what the collection says, whatever it is called here.
void requireTrueName(const Wanted& wanted) {
  if (wanted.named == nullptr) return;
  const auto [x, y, z] = wanted.named->dims;
  const std::string_view type = wanted.named->type;
  const std::string wrong = falseInName(wanted.target.filename().string(), {x, y, z},
                                        parseVoxelType(type).value(), std::endian::little);
  if (!wrong.empty())
    fail("{}: the name says {}, and {} has {} x {} x {} voxels, {}; give another name with -o",
         wanted.target.string(), wrong, wanted.named->name, x, y, z, type);
}

void requireFree(const Wanted& wanted, bool force) {
  std::error_code ignored;
  const fs::file_status status = fs::status(wanted.target, ignored);
  if (!fs::exists(status)) return;
  if (fs::is_directory(status))
    fail("{}: there is such a folder already; give another name with -o, or remove it",
         wanted.target.string());
  if (!force) fail("{}: there is such a file already; --force replaces it", wanted.target.string());
}

// Shows the terms. Throws Error if they have to be accepted and are not.
void showTerms(const Wanted& wanted, const FetchArguments& arguments) {
  const bool is_silent = arguments.json || arguments.quiet;
  if (wanted.named == nullptr) {
    if (!is_silent)
      say("{}\n  Terms: those of its publisher, which sluice does not know.\n",
          wanted.shown_address);
    return;
  }
  const NamedVolume& volume = *wanted.named;
  // Terms that are not accepted yet are shown in any case.
  if (!is_silent || !arguments.accepts)
    say("{}: {}\n  {} x {} x {} voxels, {}, {}\n  {}\n  Terms: {}\n", volume.name, volume.what,
        volume.dims[0], volume.dims[1], volume.dims[2], volume.type, formatBytes(volume.bytes()),
        wanted.shown_address, volume.terms());
  if (!arguments.accepts)
    fail("{}: nothing was fetched; give --accept-licence if you accept these terms", volume.name);
}

nlohmann::json reportOf(const Wanted& wanted, const FetchedVolume& fetched, double seconds) {
  nlohmann::json report{{"command", "fetch"},
                        {"address", wanted.shown_address},
                        {"output", wanted.target.string()},
                        {"bytes", fetched.object.bytes},
                        {"resumed_bytes", fetched.object.resumed_bytes},
                        {"seconds", seconds}};
  if (wanted.named != nullptr) report["terms"] = wanted.named->terms();
  if (fetched.is_store) {
    report["files"] = fetched.files;
    report["missing_files"] = fetched.missing_files;
  } else {
    report["sha256"] = fetched.object.sha256;
  }
  return report;
}

void print(const Wanted& wanted, const FetchedVolume& fetched, double seconds) {
  const std::string target = wanted.target.string();
  say("{}\n  {} in {:.1f} s", target, formatBytes(fetched.object.bytes), seconds);
  if (fetched.object.resumed_bytes > 0)
    say(", {} of them were there already", formatBytes(fetched.object.resumed_bytes));
  if (fetched.is_store)
    say("\n  {} files; {} chunks are missing and have the fill value\n", fetched.files,
        fetched.missing_files);
  else
    say("\n  SHA-256 {}{}\n", fetched.object.sha256,
        wanted.expected.sha256.empty() ? ", with which nothing was compared" : ", as expected");
  if (wanted.named != nullptr)
    say("  sluice render {}{} -o {}.png\n", target, wanted.named->options(), wanted.named->name);
}

int printList(bool as_json) {
  nlohmann::json rows = nlohmann::json::array();
  for (const NamedVolume& volume : namedVolumes()) {
    rows.push_back({{"name", volume.name},
                    {"what", volume.what},
                    {"bytes", volume.bytes()},
                    {"address", volume.address()},
                    {"sha256", volume.sha256},
                    {"terms", volume.terms()},
                    {"options", volume.options()}});
    if (!as_json) say("{:<36} {:>10}  {}\n", volume.name, formatBytes(volume.bytes()), volume.what);
  }
  if (as_json) sayJson({{"command", "fetch"}, {"volumes", rows}});
  return kDone;
}

int run(const FetchArguments& arguments) {
  if (arguments.lists) return printList(arguments.json);
  if (arguments.what.empty())
    throw CLI::ValidationError("fetch", "expected a name (--list prints them) or an address");
  const Wanted wanted = wantedBy(arguments);
  requireFree(wanted, arguments.force);
  requireTrueName(wanted);
  showTerms(wanted, arguments);
  FetchOptions options;
  options.expected = wanted.expected;
  options.open.stop = interruption();
  options.open.web.find_buckets = [] { return bucketAccess(); };
  options.open.web.certificates = webCertificates();
  options.download.stop = interruption();
  const Stopwatch watch;
  FetchedVolume fetched;
  {
    ProgressMeter progress(arguments.quiet ? ProgressWatch() : progressLine("fetching"));
    fetched = fetchVolume(wanted.address, wanted.target, options, progress);
  }
  const double seconds = watch.seconds();
  if (arguments.json)
    sayJson(reportOf(wanted, fetched, seconds));
  else if (!arguments.quiet)
    print(wanted, fetched, seconds);
  return kDone;
}

std::optional<std::string> checksum(const std::string& word) {
  constexpr size_t kDigits = 64;
  std::string digits;
  for (const char c : word) {
    if (std::isxdigit(static_cast<unsigned char>(c)) == 0) return std::nullopt;
    digits += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return digits.size() == kDigits ? std::optional(digits) : std::nullopt;
}

}  // namespace

Command addFetch(CLI::App& program) {
  auto arguments = std::make_shared<FetchArguments>();
  CLI::App* app = program.add_subcommand(
      "fetch",
      "Copies a public volume by its name, or any file or store by its address\n\n"
      "  sluice fetch --list\n"
      "  sluice fetch NAME --accept-licence\n\n"
      "The terms are printed first. If a run ends early, give the same command again: it\n"
      "continues where the run stopped. The file gets its name when it is complete.");
  requireNames(
      app->add_option("what", arguments->what,
                      "A name that --list prints, or the address of a file, a Zarr or an N5 store "
                      "(https://..., s3://...)"))
      ->type_name("NAME|URL")
      ->group("Volume");
  const OptionGroup volume(*app, "Volume");
  volume.flag("--list", arguments->lists, "Lists the volumes that have names, with their sizes");
  volume.flag("--accept-licence", arguments->accepts,
              "Accepts the terms that are printed; without it, no named volume is fetched");
  volume.parsed(
      "--sha256", "DIGITS", "64 hexadecimal digits", checksum,
      [arguments](const std::string& digits) { arguments->sha256 = digits; },
      "The SHA-256 that the file must have");
  const OptionGroup output(*app, kOutputHeading);
  output.text("-o,--output", "FILE", arguments->output,
              "File, or folder of a store (the last part of the address)");
  addForceOption(output, arguments->force);
  addQuietOption(output, arguments->quiet);
  addJsonOption(output, arguments->json);
  return [arguments] { return run(*arguments); };
}

}  // namespace sluice

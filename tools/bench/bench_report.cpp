#include "tools/bench/bench_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "src/base/files/text_file.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/outputs.h"
#include "tools/options/shared_options.h"
#include "tools/pages/compare_page.h"
#include "tools/pages/report_file.h"

namespace sluice {
namespace {

using nlohmann::json;

constexpr uint64_t kMostBytes = uint64_t{256} << 20;  // limit for a report

struct ReportArguments {
  std::vector<std::string> files;
  std::string output;
  bool force = false;
};

NamedReport readReport(const std::string& file) {
  const json report =
      json::parse(readTextFile(file, kMostBytes, "a report", interruption()), nullptr, false);
  // Every report of sluice names its command; other JSON would be a table of nonsense.
  if (report.is_discarded() || !report.is_object() || !report.contains("command"))
    fail(
        "{}: expected a report that sluice wrote as JSON (--report FILE.json, or --json), found {}",
        file, report.is_discarded() ? "no JSON" : "other JSON");
  return {file, report};
}

// The last part of each path, unless two are the same.
void shorten(std::vector<NamedReport>& runs) {
  std::vector<std::string> names;
  names.reserve(runs.size());
  for (const NamedReport& run : runs)
    names.push_back(std::filesystem::path(run.name).filename().string());
  for (size_t i = 0; i < runs.size(); ++i)
    if (std::count(names.begin(), names.end(), names[i]) == 1) runs[i].name = names[i];
}

void print(const std::vector<NamedReport>& runs) {
  size_t longest = 0;
  const std::vector<ComparedNumber> numbers = compared(runs);
  for (const ComparedNumber& number : numbers) longest = std::max(longest, number.name.size());
  say("{:<{}}", "", longest);
  for (const NamedReport& run : runs) say("  {:>24}", run.name);
  say("\n");
  for (const ComparedNumber& number : numbers) {
    say("{:<{}}", number.name, longest);
    for (size_t i = 0; i < runs.size(); ++i) {
      const std::string value =
          number.values[i].is_null() ? "-" : readable(number.name, number.values[i]);
      const std::string ratio = ratioText(number, i);
      say("  {:>24}", ratio.empty() ? value : fmt::format("{} ({})", value, ratio));
    }
    say("\n");
  }
}

int run(const ReportArguments& arguments) {
  Outputs outputs(arguments.force);
  // The page must not replace one of the reports that it is made of.
  outputs.reads(arguments.files);
  outputs.writes("-o", arguments.output, FileKind::kPage);
  outputs.check();
  std::vector<NamedReport> runs;
  for (const std::string& file : arguments.files) runs.push_back(readReport(file));
  shorten(runs);
  if (arguments.output.empty()) {
    print(runs);
    return kDone;
  }
  if (!isPage(arguments.output))
    fail("{}: runs side by side are written as .html", arguments.output);
  AtomicFile out(arguments.output);
  out.write(comparePage(runs));
  out.commit();
  say("{}\n", arguments.output);
  return kDone;
}

}  // namespace

Command addBenchReport(CLI::App& bench) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* app = bench.add_subcommand(
      "report",
      "Runs side by side, each number against the first run's, as a table or as a page\n\n"
      "  sluice bench report before.json after.json -o runs.html");
  requireNames(app->add_option("FILE", arguments->files,
                               "Reports that --report or --json gave, two or more"))
      ->type_name("FILE")
      ->required()
      ->expected(2, 100);
  const OptionGroup output(*app, kOutputHeading);
  output.text("-o,--output", "FILE", arguments->output, "A page, .html, in place of a table");
  addForceOption(output, arguments->force);
  return [arguments] { return run(*arguments); };
}

}  // namespace sluice

// sluice bench: speeds of this machine and of the renderer, as medians.
#include <filesystem>
#include <memory>
#include <sstream>

#include "tools/bench/bench.h"
#include "tools/bench/bench_report.h"
#include "tools/command_line/console.h"
#include "tools/command_line/outputs.h"
#include "tools/command_line/usage.h"
#include "tools/commands/commands.h"
#include "tools/outputs/report.h"
#include "tools/pages/report_file.h"

namespace sluice {
namespace {

// A report may not replace a file that the bench reads by name, nor a file that is no report.
// --force is not for benches, since only the volume's reader would know all files that it reads.
Outputs outputsOf(const CLI::App& app, const std::string& report) {
  Outputs outputs;
  for (const CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();
    const bool is_read = type == "VOLUME" || type == "FILE" || type == "FILE,...";
    if (!is_read || option->check_lname("report")) continue;
    for (const std::string& word : option->results()) {
      std::stringstream names(word);
      for (std::string name; std::getline(names, name, ',');)
        outputs.reads(std::filesystem::path(name));
    }
  }
  outputs.writes("--report", report, reportKind(report));
  return outputs;
}

// Throws a usage error for several channels that a bench of one would take the first of.
void requireOneChannel(const CLI::App& bench) {
  const CLI::Option* const option = bench.get_option_no_throw("--channel");
  for (const std::string& word : option != nullptr ? option->results() : CLI::results_t())
    if (word.find(',') != std::string::npos)
      failUsage("--channel: bench {} measures one channel, found '{}'; give one", bench.get_name(),
                word);
}

// The destination of a report.
struct ReportOutput {
  std::string file;
  bool json = false;
};

}  // namespace

Command addBench(CLI::App& program) {
  CLI::App* app =
      program.add_subcommand("bench", std::string("Measures speeds\n\n") + kPlainPicture +
                                          "  sluice bench render bonsai.nii.gz --threshold 40");
  app->require_subcommand(1);
  std::vector<Bench> benches;
  for (const auto add : kBenches) benches.push_back(add(*app));
  auto output = std::make_shared<ReportOutput>();
  for (const Bench& bench : benches) {
    const OptionGroup group(*bench.app, kOutputHeading);
    addReportOption(group, output->file);
    addJsonOption(group, output->json);
  }
  const Command compare = addBenchReport(*app);
  return [=] {
    for (const Bench& bench : benches) {
      if (!bench.app->parsed()) continue;
      if (!bench.shows_channels) requireOneChannel(*bench.app);
      outputsOf(*bench.app, output->file).check();
      return bench.run([&](nlohmann::json report, Print print) -> int {
        report.update(
            {{"command", "bench " + bench.app->get_name()}, {"options", optionsJson(*bench.app)}});
        if (!output->file.empty()) writeReport(output->file, report);
        if (output->json)
          sayJson(report);
        else
          print(report);
        return kDone;
      });
    }
    return compare();
  };
}

}  // namespace sluice

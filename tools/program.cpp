#include "tools/program.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <exception>

#include "src/base/error.h"
#include "src/base/field_names.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/help.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/usage.h"
#include "tools/manual/help_files.h"
#include "tools/options/table_options.h"
#include "tools/scene/ranks.h"

namespace sluice {
namespace {

struct CommandEntry {
  const char* heading;  // in the overview
  const char* name;
  Command (*add)(CLI::App& program);
};
// In the order of the overview.
constexpr std::array kCommands = std::to_array<CommandEntry>({
    {"Pictures", "render", addRender},
    {"Pictures", "view", addView},
    {"Pictures", "surface", addSurface},
    {"Pictures", "info", addInfo},
    {"Pictures", "plan", addPlan},
    {"Volumes", "synth", addSynth},
    {"Volumes", "pack", addPack},
    {"Volumes", "fetch", addFetch},
    {"Volumes", "prepare", addPrepare},
    {"Measuring", "simulate", addSimulate},
    {"Measuring", "bench", addBench},
    {"Measuring", "doctor", addDoctor},
});

// The other commands would do everything as often as there are ranks.
bool isForRanks(const CLI::App& program) {
  const CLI::App* asked = program.get_subcommands().front();
  if (asked->get_name() == "render") return true;
  return asked->get_name() == "bench" && !asked->get_subcommands().empty() &&
         asked->get_subcommands().front()->get_name() == "ranks";
}

// "help", "help render", "-h" and nothing at all ask for the overview or for a command's options.
std::vector<std::string> withoutHelpWord(const std::vector<std::string>& words) {
  if (words.empty() || words.front() != "help") return words;
  std::vector<std::string> rest(words.begin() + 1, words.end());
  rest.emplace_back("--help");
  return rest;
}

// "sluice render bonsai.nii.gz bonsai.png": the last word is a file to write, without its option.
std::string missingOutputHint(const CLI::App& program, const CLI::RequiredError& error,
                              const std::vector<std::string>& words) {
  const std::string& last = words.back();
  std::error_code none;
  if (!std::string_view(error.what()).starts_with("--output") || last.starts_with("-") ||
      words.size() < 3 || std::filesystem::exists(last, none))
    return "";
  // The value of an option names no picture: "-j 1".
  const auto commands = program.get_subcommands(
      [&](const CLI::App* command) { return command->get_name() == words.front(); });
  for (const CLI::App* command : commands) {
    const CLI::Option* const before = command->get_option_no_throw(words[words.size() - 2]);
    if (before != nullptr && before->get_items_expected_max() > 0) return "";
  }
  return fmt::format("; to write {}, give -o {}", last, last);
}

int parseAndRun(const std::vector<std::string>& given, const Launch& launch) {
  // The build calls "help --files FOLDER"; no help lists it.
  if (given.size() == 3 && given[0] == "help" && given[1] == "--files") {
    writeHelpFiles(*makeCommandLine().program, given[2]);
    return kDone;
  }
  const std::vector<std::string> words = withoutHelpWord(given);
  if (words.empty() || words.front() == "--help" || words.front() == "-h") {
    sayText(overview(*makeCommandLine().program));
    return kDone;
  }
  // The options of all commands are 1400; making them took half of the time of a short command.
  const CommandLine line = makeCommandLine(words.front());
  CLI::App& program = *line.program;
  // The complaint may name other commands.
  if (wrongUsage(program, words))
    return refuseTogether(launch, *wrongUsage(*makeCommandLine().program, words), kUsage);
  try {
    // CLI11 takes a list of words from its end.
    program.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::CallForHelp&) {
    const CLI::App* asked = &program;
    while (!asked->get_subcommands().empty()) asked = asked->get_subcommands().front();
    sayText(asked->help());
    return kDone;
  } catch (const CLI::CallForAllHelp&) {
    const CLI::App* asked = &program;
    while (!asked->get_subcommands().empty()) asked = asked->get_subcommands().front();
    sayText(asked->help("", CLI::AppFormatMode::All));
    return kDone;
  } catch (const CLI::CallForVersion&) {
    say("{}\n", SLUICE_VERSION);
    return kDone;
  } catch (const CLI::RequiredError& error) {
    return refuseTogether(launch, error.what() + missingOutputHint(program, error, words), kUsage);
  } catch (const CLI::ParseError& error) {
    return refuseTogether(launch, error.what(), kUsage);
  }
  if (launch.ranks > 1 && !isForRanks(program))
    return refuseTogether(
        launch,
        fmt::format("started as {} ranks; render and bench ranks run on several, {} on one: start "
                    "it without the launcher",
                    launch.ranks, program.get_subcommands().front()->get_name()),
        kFailed);
  for (const auto& [subcommand, command] : line.commands)
    if (subcommand->parsed()) {
      try {
        return command();
      } catch (const CLI::ParseError& error) {  // an error that only the command itself can find
        if (launch.rank == 0) printError(error.what());
        return kUsage;
      }
    }
  return kUsage;
}

}  // namespace

CommandLine makeCommandLine(std::string_view only) {
  CommandLine line;
  line.program = std::make_unique<CLI::App>("sluice " SLUICE_VERSION
                                            ": renders volumes larger than memory\n\n"
                                            "  sluice render bonsai.nii.gz -o bonsai.png",
                                            "sluice");
  CLI::App& program = *line.program;
  program.formatter(std::make_shared<HelpFormatter>());
  program.set_version_flag("-V,--version", SLUICE_VERSION);
  program.require_subcommand(1);
  const bool is_known = std::ranges::find(kCommands, only, &CommandEntry::name) != kCommands.end();
  for (const auto& [heading, name, add] : kCommands) {
    if (is_known && name != only) continue;
    Command command = add(program);
    CLI::App* made = program.get_subcommands(nullptr).back();
    SLUICE_CHECK(made->get_name() == name);
    made->group(heading);
    pairOptions(*made);
    if (hasShortHelp(*made)) made->set_help_all_flag("--help-all", "Prints all options and exits");
    line.commands.emplace_back(made, std::move(command));
  }
  return line;
}

int runProgram(const std::vector<std::string>& words) {
  int status = kFailed;
  Launch launch;
  // With several ranks, the first prints for all.
  const auto tell = [&launch](const char* line) {
    if (line != nullptr && launch.rank == 0) printError(line);
  };
  try {
    watchForInterruption();
    launch = beginRanks();
    // A launcher whose run ends early ends each of its processes, and prints why.
    if (launch.ranks > 1) sayWhenInterrupted(nullptr);
    prepareDriver();
    status = parseAndRun(words, launch);
    finishOutput();
    return status;
  } catch (const Interrupted&) {
    if (launch.ranks > 1 && interruptionStatus() == 128 + SIGINT) tell("interrupted");
    tell(interruptedLine());
    return interruptionStatus();
  } catch (const std::bad_alloc&) {
    tell("out of memory; give a smaller --memory or a larger machine");
  } catch (const std::exception& error) {
    tell(lineInOptions(error).c_str());
  }
  return kFailed;
}

}  // namespace sluice

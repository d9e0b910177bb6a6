#include "tools/program.h"

#include <exception>

#include "tools/command_line/console.h"
#include "tools/command_line/help.h"
#include "tools/command_line/usage.h"
#include "tools/environment.h"
#include "tools/interrupt.h"

namespace sluice {
namespace {

struct Heading {
  const char* title;
  std::vector<Command (*)(CLI::App&)> commands;
};

int usageError(const std::string& line) {
  printError(line);
  return kUsage;
}

// "help", "help render", "-h" and nothing at all ask for the overview or for a command's options.
std::vector<std::string> withoutHelpWord(const std::vector<std::string>& words) {
  if (words.empty() || words.front() != "help") return words;
  std::vector<std::string> rest(words.begin() + 1, words.end());
  rest.emplace_back("--help");
  return rest;
}

int parseAndRun(const CommandLine& line, const std::vector<std::string>& given) {
  CLI::App& program = *line.program;
  const std::vector<std::string> words = withoutHelpWord(given);
  if (words.empty() || words.front() == "--help" || words.front() == "-h") {
    say("{}", overview(program));
    return kDone;
  }
  if (const auto wrong = wrongUsage(program, words)) return usageError(*wrong);
  try {
    program.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::CallForHelp&) {
    const CLI::App* asked = &program;
    while (!asked->get_subcommands().empty()) asked = asked->get_subcommands().front();
    say("{}", asked->help());
    return kDone;
  } catch (const CLI::CallForVersion&) {
    say("{}\n", SLUICE_VERSION);
    return kDone;
  } catch (const CLI::ParseError& error) {
    return usageError(error.what());
  }
  for (const auto& [subcommand, command] : line.commands)
    if (subcommand->parsed()) {
      try {
        return command();
      } catch (const CLI::ParseError& error) {  // what only the command itself can tell
        return usageError(error.what());
      }
    }
  return kUsage;
}

}  // namespace

CommandLine makeCommandLine() {
  CommandLine line;
  line.program = std::make_unique<CLI::App>("sluice " SLUICE_VERSION
                                            ": renders volumes larger than memory\n\n"
                                            "  sluice render bonsai.nii.gz -o bonsai.png",
                                            "sluice");
  CLI::App& program = *line.program;
  program.formatter(std::make_shared<HelpFormatter>());
  program.set_version_flag("-V,--version", SLUICE_VERSION);
  program.require_subcommand(1);
  const std::vector<Heading> headings = {{"Pictures", {addRender, addView, addInfo, addPlan}},
                                         {"Volumes", {addSynth, addPack, addPrepare}},
                                         {"Measuring", {addSimulate, addBench, addDoctor}}};
  for (const auto& [title, commands] : headings)
    for (const auto add : commands) {
      Command command = add(program);
      CLI::App* made = program.get_subcommands(nullptr).back();
      made->group(title);
      line.commands.emplace_back(made, std::move(command));
    }
  return line;
}

int runProgram(const std::vector<std::string>& words) {
  int status = kFailed;
  try {
    watchForInterruption();
    prepareDriver();
    const CommandLine line = makeCommandLine();
    status = parseAndRun(line, words);
    finishOutput();
    return status;
  } catch (const Interrupted&) {
    printError("interrupted");
    return interruptionStatus();
  } catch (const std::bad_alloc&) {
    printError("out of memory; give a smaller --memory or a larger machine");
  } catch (const std::exception& error) {
    printError(error.what());
  }
  return kFailed;
}

}  // namespace sluice

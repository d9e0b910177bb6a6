// sluice: renders volumes larger than memory, from the command line.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <malloc.h>

#include <cstdio>
#include <exception>
#include <vector>

#include "src/base/interrupt.h"
#include "tools/commands.h"

namespace {

constexpr int kBadInput = 1, kUsage = 2, kInterrupted = 130;

// One line, whatever the message holds.
void printError(std::string line) {
  for (char& c : line)
    if (c == '\n') c = ' ';
  fmt::print(stderr, "sluice: {}\n", line);
}

}  // namespace

int main(int argc, char** argv) {
  // Blocks and chunks go back to the system when they are freed: what --memory bounds is what the
  // process takes, not what its allocator keeps.
  constexpr int kMapFromBytes = 128 << 10;
  mallopt(M_MMAP_THRESHOLD, kMapFromBytes);
  // But for what a frame's small pieces take together: they come again with the next frame.
  constexpr int kKeptBytes = 8 << 20;
  mallopt(M_TRIM_THRESHOLD, kKeptBytes);
  try {
    CLI::App program(
        "Renders volumes larger than memory.\n\n"
        "  sluice render bonsai.nii.gz -o bonsai.png --threshold 40\n\n"
        "`sluice COMMAND --help` has a command's options. Sizes take K, M, G, T.",
        "sluice");
    program.set_version_flag("--version", SLUICE_VERSION);
    program.require_subcommand(1);
    std::vector<std::pair<CLI::App*, sluice::Command>> commands;
    for (const auto add :
         {sluice::addInfo, sluice::addRender, sluice::addPlan, sluice::addSimulate,
          sluice::addSynth, sluice::addPack, sluice::addDoctor, sluice::addBench}) {
      sluice::Command command = add(program);
      commands.emplace_back(program.get_subcommands(nullptr).back(), std::move(command));
    }
    try {
      program.parse(argc, argv);
    } catch (const CLI::Success& success) {  // --help, --version
      return program.exit(success);
    } catch (const CLI::ParseError& error) {
      printError(std::string(error.what()) + " (see sluice --help)");
      return kUsage;
    }
    sluice::watchForInterruption();
    for (const auto& [subcommand, command] : commands)
      if (subcommand->parsed()) return command();
    return kUsage;
  } catch (const sluice::Interrupted&) {
    printError("interrupted");
    return kInterrupted;
  } catch (const std::bad_alloc&) {
    printError("out of memory; give a smaller --memory or a larger machine");
    return kBadInput;
  } catch (const std::exception& error) {
    printError(error.what());
    return kBadInput;
  }
}

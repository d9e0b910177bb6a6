// The subcommands of the program, one file each. Each adds itself to the command line. The returned
// function runs when its subcommand was given, and its result is the exit status.
#pragma once

#include <functional>

// Its header takes the compiler seconds.
namespace CLI {
class App;
}

namespace sluice {

// In addition, the values of interruptionStatus().
enum ExitStatus : int { kDone = 0, kFailed = 1, kUsage = 2 };

using Command = std::function<int()>;

// The functions may throw Error, Interrupted and CLI::ParseError, which program.cpp reports.
Command addInfo(CLI::App& program);
Command addRender(CLI::App& program);
Command addView(CLI::App& program);
Command addPlan(CLI::App& program);
Command addPrepare(CLI::App& program);
Command addSurface(CLI::App& program);
Command addSimulate(CLI::App& program);
Command addSynth(CLI::App& program);
Command addPack(CLI::App& program);
Command addFetch(CLI::App& program);
Command addDoctor(CLI::App& program);
Command addBench(CLI::App& program);

}  // namespace sluice

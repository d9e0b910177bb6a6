// sluice bench report: runs side by side, from their JSON reports.
#pragma once

#include "tools/commands/commands.h"

namespace sluice {

// A subcommand of bench: `bench report A.json B.json [-o runs.html]`.
Command addBenchReport(CLI::App& bench);

}  // namespace sluice

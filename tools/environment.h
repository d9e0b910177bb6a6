// The environment variables that the program looks at (docs/command-line.md). The library looks at
// none.
#pragma once

#include <filesystem>
#include <string>

#include "io/headers/decode_options.h"
#include "src/index/index_file.h"
#include "src/parallel/mpi_ranks.h"

namespace sluice {

// Where indices go: `index_dir` (--index-dir), $SLUICE_INDEX_DIR, $XDG_CACHE_HOME/sluice/index or
// ~/.cache/sluice/index, the first that is said. SLUICE_INDEX=beside: beside the volume, where no
// --index-dir is given. SLUICE_INDEX=off: nowhere.
IndexWish indexWish(const std::string& index_dir);

// What the window keeps from one sitting to the next: $XDG_CONFIG_HOME/sluice/view.json or
// ~/.config/sluice/view.json; empty where neither is said.
std::filesystem::path windowSettings();

// In $TMPDIR, with a line of progress.
DecodeOptions decodeOptions();

// Which rank of how many a launcher has started this process as.
Launch launchOfProcess();

// Adds what pictures need to the flags that the user has for Mesa (gl_choice.h), which the driver
// reads. Called once, before there are threads.
void prepareDriver();

}  // namespace sluice

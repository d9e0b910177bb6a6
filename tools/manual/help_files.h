// The files that shells and man(1) read instead of --help. The build writes them by
// `sluice help --files FOLDER`, and `cmake --install` puts them into PREFIX/share.
#pragma once

#include <CLI/CLI.hpp>

#include <filesystem>

namespace sluice {

// Writes man/man1/*.1 and the completions of bash, zsh and fish under `folder`, which is made.
// Throws Error.
void writeHelpFiles(CLI::App& program, const std::filesystem::path& folder);

}  // namespace sluice

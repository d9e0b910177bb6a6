// Volumes that a Python script of tests/tools writes: made once for all tests, each of which gets a
// copy.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "tests/support/made_once.h"
#include "tests/tools/program.h"

namespace sluice {

// Copies what `SCRIPT write` leaves in a folder into `into`. False if one of the Python modules
// that it needs is missing.
inline bool copyScriptFiles(const std::string& script, const std::string& modules,
                            const std::filesystem::path& into) {
  const std::string path = SLUICE_TEST_DIR "/tools/" + script;
  const std::string name =
      fmt::format("{}-{:016x}", script, std::hash<std::string>()(readFile(path)));
  const auto folder = madeOnce(name, [&](const std::filesystem::path& made) {
    if (runCommand("/usr/bin/python3 -c 'import " + modules + "'").status != 0) return false;
    const CommandResult written =
        runCommand("cd " + shellQuoted(made.string()) + " && /usr/bin/python3 " +
                   shellQuoted(path) + " write");
    EXPECT_EQ(written.output, "");
    return written.status == 0;
  });
  if (folder.empty()) return false;
  std::filesystem::copy(folder, into, std::filesystem::copy_options::recursive);
  return true;
}

}  // namespace sluice

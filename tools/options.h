// How the arguments that commands share are put on a command line.
// The names are those of the interface that scripts read; nothing is renamed.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

#include "src/render/frame_options.h"
#include "tools/arguments.h"

namespace sluice {

void addVolumeOptions(CLI::App& app, VolumeArguments& arguments);
void addLookOptions(CLI::App& app, LookArguments& arguments);
void addViewOptions(CLI::App& app, FrameOptions& options);
void addResourceOptions(CLI::App& app, ResourceArguments& arguments);

// An option whose word `parse` turns into a value; a word that it refuses (nullopt) is a usage
// error that says what was expected.
template <class Parse, class Take>
CLI::Option* addParsed(CLI::App& app, const std::string& name, const std::string& help,
                       const std::string& expected, Parse parse, Take take) {
  return app
      .add_option_function<std::string>(
          name,
          [=](const std::string& word) {
            const auto value = parse(word);
            if (!value)
              throw CLI::ValidationError(name, "expected " + expected + ", found '" + word + "'");
            take(*value);
          },
          help)
      ->type_name(expected);
}

}  // namespace sluice

// The options that commands share, with their defaults, and how they are put on a command line.
// The names are those of the interface that scripts read; nothing is renamed.
#pragma once

#include <CLI/CLI.hpp>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cache/policy.h"
#include "io/open_volume.h"
#include "src/gl/context.h"
#include "src/render/frame_options.h"

namespace sluice {

// Which volume, and how to read it where the file does not say.
struct VolumeArguments {
  std::vector<std::string> inputs;
  OpenOptions open;
  int64_t time = 0;
};

// How it looks.
struct LookArguments {
  std::optional<double> threshold;
  std::string transfer_file;
  std::string map;
  std::optional<double> opacity;
  bool shade = false;
  bool modulate = false;       // the opacity by the gradient's magnitude
  double full_gradient = 0.1;  // where that is 1: a share of the value range a voxel length
  std::array<float, 3> background{0, 0, 0};
  bool has_background = false;
};

// What it may take.
struct ResourceArguments {
  uint64_t memory_bytes = 0;  // 0: half of what the machine has
  int threads = 0;            // 0: one a core
  GlChoice gl = GlChoice::kAuto;
  std::optional<Vec3i> page_vox;
  std::optional<int64_t> pages;
  std::optional<int64_t> block;
  PolicyKind policy = PolicyKind::kLru;
  uint64_t seed = 1;
};

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

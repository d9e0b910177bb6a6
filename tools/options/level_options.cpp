#include "src/base/error.h"
#include "src/library/drawing/resources.h"
#include "src/render/blocks/cut_rules.h"
#include "tools/options/shared_options.h"

namespace sluice {

void addLevelOptions(CLI::App& app, LevelArguments& arguments, ResourceArguments& resources) {
  const OptionGroup group(app, kLevelsHeading);
  addLevelOption(group, arguments.level, "Draws this level only; 0 is the data as stored");
  group.rare().number(
      "--pixel-error", "PIXELS", arguments.pixel_error, {0, 1e6, true},
      "Draws each part at the coarsest level whose voxels are at most this wide (1)");
  group.rare().bytes(
      "--max-bytes", arguments.max_bytes,
      "Refines levels until the blocks of a picture would exceed this many bytes of stored "
      "voxels (no limit)");
  group.flag("--keep-thin", arguments.keeps_thin,
             "Refines parts where level 0 shows something thinner than two coarse voxels");
  addLevelsOption(group, resources);
}

void addLevelOption(const OptionGroup& group, std::optional<int64_t>& level,
                    const std::string& help) {
  constexpr int64_t kMostLevel = 63;
  group.rare().number("--level", "N", level, {0, kMostLevel}, help);
}

void addLevelsOption(const OptionGroup& group, MachineOptions& machine) {
  group.choice(
      "--levels",
      Words<LevelsWish>{{"auto", LevelsWish::kAuto},
                        {"always", LevelsWish::kAlways},
                        {"none", LevelsWish::kNone}},
      machine.levels,
      "Whether to make coarser levels, once and beside the index, for a file that has none: if it "
      "is large (auto), always, or never (none)");
}

std::optional<CutOptions> cutOptions(const LevelArguments& arguments,
                                     const ResourceArguments& resources, const LookArguments& look,
                                     const FrameOptions& frame, PictureRow row) {
  if (arguments.level == 0) return std::nullopt;
  CutOptions cut;
  cut.is_default = !arguments.level && !arguments.pixel_error && arguments.max_bytes == 0;
  // Level 0 is drawn then, and opened as a volume of one level is. Growing boxes are boxes of its
  // voxels.
  if (cut.is_default &&
      (!suitDefaultCut(frame.mode, look.labels) || frame.partition == Partition::kBoxes))
    return std::nullopt;
  cut.keeps_thin = arguments.keeps_thin;
  cut.pixel_error = arguments.pixel_error.value_or(cut.pixel_error);
  if (arguments.level) cut.level = static_cast<int>(*arguments.level);
  if (arguments.max_bytes != 0) cut.most_stored_bytes = arguments.max_bytes;
  cut.most_held_bytes = cutBytes(memoryBudget(resources), row);
  return cut;
}

void refuseLevels(const LevelArguments& arguments, std::string_view why) {
  const bool asks = arguments.level.value_or(0) > 0 || arguments.max_bytes != 0 ||
                    arguments.pixel_error || arguments.keeps_thin;
  if (asks) fail("{}; leave out --level, --pixel-error, --max-bytes and --keep-thin", why);
}

}  // namespace sluice

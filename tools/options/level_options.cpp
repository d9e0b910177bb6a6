#include "src/library/conversions.h"
#include "src/library/drawing/scene/resources.h"
#include "src/render/blocks/cut/cut_rules.h"
#include "tools/command_line/usage.h"
#include "tools/options/shared_options.h"

namespace sluice {

void addLevelOptions(CLI::App& app, const AskedView& asked, FrameOptions& frame,
                     ResourceArguments& resources) {
  const auto take = [&app, &frame](const ViewState& state) {
    frame.cut = askedCut(state);
    // A picture error that is given asks for a cut, even if it is the default one.
    if (frame.cut && app.count("--pixel-error") > 0) frame.cut->is_default = false;
  };
  frame.cut = askedCut(*asked);
  TableOptions(app, asked, take).addRest(kLevelsHeading, OptionPart::kPicture);
  app.get_option("--pixel-error")->default_str("");  // 1, of pictures that are drawn from a cut
  addLevelsOption(OptionGroup(app, std::string(kLevelsHeading)), resources);
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

std::optional<CutOptions> cutOptions(const ResourceArguments& resources, const LookArguments& look,
                                     const FrameOptions& frame, PictureRow row) {
  std::optional<CutOptions> cut = frame.cut;
  // Level 0 is drawn then, and opened as a volume of one level is. Growing boxes are boxes of its
  // voxels.
  if (!cut || (cut->is_default &&
               (!suitDefaultCut(frame.mode, look.labels) || frame.partition == Partition::kBoxes)))
    return std::nullopt;
  cut->most_held_bytes = cutBytes(memoryBudget(resources), row);
  return cut;
}

void refuseLevels(const std::optional<CutOptions>& asked, std::string_view why) {
  if (asked && (!asked->is_default || asked->keeps_thin))
    failUsage("{}; leave out --level, --pixel-error, --max-bytes and --keep-thin", why);
}

}  // namespace sluice

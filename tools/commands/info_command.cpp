// sluice info: the properties of a volume, and its index, which is built if it is missing.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <string>

#include "src/base/sources/level_kinds.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_times.h"
#include "src/base/values/bytes.h"
#include "src/library/opening/thick_source.h"
#include "src/volume/ranges/slice_ranges.h"
#include "src/volume/voxels/device_voxel.h"
#include "tools/command_line/console.h"
#include "tools/commands/commands.h"
#include "tools/options/shared_options.h"
#include "tools/outputs/cut_report.h"
#include "tools/outputs/report.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

struct InfoArguments {
  VolumeArguments volume;
  ResourceArguments resources;
  bool levels = false;
  bool json = false;
};

// Whether pictures leave out a level.
bool isLeftOut(const IndexedVolume& volume, size_t level) {
  return !volume.levels_fault.empty() && level >= static_cast<size_t>(volume.pyramid->levels());
}

// A line for each level: its voxels, and their places among those of level 0.
void printLevels(const IndexedVolume& volume) {
  const VolumeSource& source = *volume.source;
  const VolumeLayout& layout = source.layout();
  const auto triple = [](auto v) { return fmt::format("{:g} x {:g} x {:g}", v.x, v.y, v.z); };
  const auto line = [&](size_t level, Vec3i dims, const LevelPlacement& place,
                        const std::string& spread) {
    const auto voxels = static_cast<uint64_t>(dims.x * dims.y * dims.z);
    const Vec3d offset = place.offset;
    say("  level {}: {} x {} x {} voxels, {}; one is {} of level 0, the first at ({:g}, {:g}, "
        "{:g}); spacing {}{}\n",
        level, dims.x, dims.y, dims.z, formatBytes(voxels * bytesPerVoxel(layout.type)),
        triple(place.scale), offset.x, offset.y, offset.z, triple(layout.spacing * place.scale),
        spread);
  };
  line(0, layout.dims, {}, "");
  size_t level = 0;
  for (const CoarserLevel& coarser : coarserLevels(source)) {
    ++level;
    line(level, coarser.source->layout().dims, coarser.placement,
         fmt::format("; {}, {}: {}{}", wordOf(coarser.values),
                     coarser.values == LevelValues::kModes ? "share" : "spread",
                     coarser.spreads == nullptr ? "none" : name(coarser.spreads->layout().type),
                     isLeftOut(volume, level) ? "; left out of pictures" : ""));
  }
  if (!volume.levels_fault.empty())
    say("  level {} is left out, with all above it: {}\n", volume.pyramid->levels(),
        volume.levels_fault);
  for (const LevelValues values : kLevelKinds)
    if (const auto levels = levelsOfKind(source, values); !levels.empty())
      say("  {} levels of {} beside them\n", levels.size(), wordOf(values));
}

nlohmann::json levelsJson(const IndexedVolume& volume) {
  const VolumeSource& source = *volume.source;
  const auto triple = [](auto v) { return nlohmann::json::array({v.x, v.y, v.z}); };
  nlohmann::json levels = nlohmann::json::array();
  const auto add = [&](Vec3i dims, const LevelPlacement& place, const char* values,
                       bool has_spreads) {
    nlohmann::json also = nlohmann::json::array();
    for (const LevelValues kind : kLevelKinds)
      if (!levels.empty() && levelsOfKind(source, kind).size() >= levels.size())
        also.push_back(wordOf(kind));
    levels.push_back({{"dims", triple(dims)},
                      {"scale", triple(place.scale)},
                      {"offset", triple(place.offset)},
                      {"spacing", triple(source.layout().spacing * place.scale)},
                      {"values", values},
                      {"spreads", has_spreads},
                      {"left_out", isLeftOut(volume, levels.size()) ? volume.levels_fault : ""},
                      {"also", also}});
  };
  add(source.layout().dims, {}, "voxels", false);
  for (const CoarserLevel& coarser : coarserLevels(source))
    add(coarser.source->layout().dims, coarser.placement, wordOf(coarser.values),
        coarser.spreads != nullptr);
  return levels;
}

std::string orientationText(const VolumeLayout& layout) {
  switch (layout.frame) {
    case WorldFrame::kRas:
    case WorldFrame::kLps: {
      const std::string letters = axisLetters(layout);
      return fmt::format("orientation {}, the world's is {}", letters.empty() ? "oblique" : letters,
                         layout.frame == WorldFrame::kRas ? "RAS" : "LPS");
    }
    case WorldFrame::kPictureRows:
      return "orientation: x to the right, y down the rows, z through the stack";
    case WorldFrame::kYUp:
      return "orientation: y up";
    case WorldFrame::kNone:
      break;
  }
  return "orientation not said";
}

// ", 2.5 second apart, the first at 10".
std::string timesText(const VolumeSource& source) {
  const std::optional<TimeAxis> times = timesOf(source);
  if (!times) return "";
  const auto& [step, start, unit] = *times;
  return fmt::format(", {:g}{} apart, the first at {:g}", step, unit.empty() ? "" : " " + unit,
                     start);
}

// A value with the digits that the file's type and scale give it, and none of the rounding.
std::string valueText(const VolumeLayout& layout, double value) {
  if (layout.type == VoxelType::kF32) return fmt::format("{:.9g}", value);
  const bool is_scaled = layout.value_scale != 1 || layout.value_offset != 0;
  return is_scaled ? fmt::format("{:.12g}", value) : fmt::format("{}", value);
}

// The value of the blocks that are not held.
std::string backgroundText(const VolumeLayout& layout, const SliceRanges& ranges) {
  const double device = ranges.background;
  // Infinities and NaN are kept as the largest floats (kLargest, kNotANumber).
  if (ranges.map.type == DeviceType::kF32 && std::abs(device) >= kLargest)
    return device <= kNotANumber ? "NaN" : device > 0 ? "inf" : "-inf";
  return valueText(layout, ranges.map.valueOf(device));
}

void print(const IndexedVolume& volume, const ChosenLook& look) {
  const VolumeLayout& layout = storedLayout(*volume.source);
  const Vec3i dims = layout.dims;
  const ValueRange range = volume.finiteRange();
  const auto voxels = static_cast<uint64_t>(sluice::volume(dims));
  say("{}\n", layout.name);
  say("  {} x {} x {} voxels, {}, {} a time step\n", dims.x, dims.y, dims.z, name(layout.type),
      formatBytes(voxels * bytesPerVoxel(layout.type)));
  say("  spacing {:.6g} x {:.6g} x {:.6g}, {} time step{}{}\n", layout.spacing.x, layout.spacing.y,
      layout.spacing.z, layout.time_steps, layout.time_steps == 1 ? "" : "s",
      timesText(*volume.source));
  const WorldBounds bounds = worldBounds(volume.source->layout());
  const auto triple = [](Vec3d v) { return fmt::format("{:g}, {:g}, {:g}", v.x, v.y, v.z); };
  say("  from ({}) to ({}){}, origin ({})\n", triple(bounds.lo), triple(bounds.hi),
      layout.unit.empty() ? ", unit not said" : " " + layout.unit, triple(layout.origin));
  if (!layout.place_fault.empty()) say("  place: {}\n", layout.place_fault);
  say("  {}\n", orientationText(layout));
  if (const std::string hint = uprightHint(layout); !hint.empty()) say("  up: {}\n", hint);
  if (layout.channels > 1) say("  channel {} of {}\n", layout.channel, layout.channels);
  if (layout.levels > 1) say("  level 0 of {} resolutions (--levels lists them)\n", layout.levels);
  if (layout.grids.size() > 1) say("  --grid takes one of: {}\n", joined(layout.grids, ", "));
  const SliceRanges& ranges = volume.index->ranges;
  if (ranges.mayHoldNumbers())
    say("  values {} to {}\n", valueText(layout, range.lo), valueText(layout, range.hi));
  else
    say("  no value is a finite number\n");
  const int64_t blocks = volume.layout.blockCount();
  // If every block is held, no voxel needs to have the value of the others.
  const auto held = static_cast<int64_t>(ranges.blocks.size());
  say("  {} block{} of {} a side{}\n", blocks, blocks == 1 ? "" : "s", volume.layout.size,
      held == blocks
          ? std::string()
          : fmt::format(", {} of them not all {}", held, backgroundText(layout, ranges)));
  // A look is chosen from the values.
  if (ranges.mayHoldNumbers())
    say("  look {}: {}{}\n", look.transfer.name, look.options(),
        layout.time_steps > 1 ? " (of this step; a picture uses the range of all steps)" : "");
  say("  index {}{}{}\n", name(volume.index->origin), volume.index->path.empty() ? "" : ": ",
      volume.index->path.string());
}

}  // namespace

Command addInfo(CLI::App& program) {
  auto arguments = std::make_shared<InfoArguments>();
  CLI::App* app = program.add_subcommand(
      "info",
      "Prints size, type, place in the world, values and index of a volume\n\n"
      "  sluice info head_256x256x225_uint8.raw --json");
  addVolumeOptions(*app, arguments->volume);
  const OptionGroup listed(*app, "Volume");
  listed.flag("--levels", arguments->levels, "Lists the levels of resolution and their places");
  addReadingOptions(*app, arguments->resources);
  const OptionGroup output(*app, kOutputHeading);
  addQuietOption(output, arguments->resources.quiet);
  addJsonOption(output, arguments->json);
  takeIdleOptions(*app);
  return [arguments] {
    Workers pool(arguments->resources.threads);
    IndexNeeds needs = kUsualNeeds;
    // Opening does not look at levels that the usual picture has no use for.
    if (arguments->levels) needs.levels = LevelNeeds::kAll;
    const IndexedVolume volume = openIndexed(arguments->volume, arguments->resources, needs, pool);
    // info prints the look that render chooses for a first picture.
    LookArguments look;
    look.first_picture = true;
    const ChosenLook chosen = lookFor(volume, look, Mode::kComposite);
    if (arguments->json) {
      nlohmann::json report = volumeJson(volume);
      report["look"] = lookJson(chosen);
      report["pyramid"] = levelsJson(volume);
      sayJson(report);
    } else if (!arguments->resources.quiet) {
      print(volume, chosen);
      if (arguments->levels) printLevels(volume);
    }
    return 0;
  };
}

}  // namespace sluice

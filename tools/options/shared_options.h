// The options that commands share, a group a function, a file a group. Scripts read these names
// (the interface); nothing is renamed. To add one is one call in the right file. An option of a
// view or a volume is an entry of the table of options instead (src/options/option_table.h): the
// functions here add all entries that have a heading.
#pragma once

#include <algorithm>
#include <optional>
#include <string_view>

#include "src/library/drawing/scene/resources.h"
#include "src/render/camera/frame_options.h"
#include "tools/command_line/option_group.h"
#include "tools/options/arguments.h"
#include "tools/options/table_options.h"

namespace sluice {

// `needs_volume`: false if the volume may be named elsewhere. `times`: --time takes a range of
// steps too, and sets it and arguments.time to its first.
void addVolumeOptions(CLI::App& app, VolumeArguments& arguments,
                      std::optional<TimeRange>* times = nullptr, bool needs_volume = true);
// --over, of commands that draw several volumes together.
void addOverOption(CLI::App& app, VolumeArguments& arguments);
// `chooses`: includes --culling; otherwise only the options of opacity functions.
void addCullingOptions(CLI::App& app, CullingArguments& arguments, bool chooses);
void addLookOptions(CLI::App& app, const AskedView& asked, LookArguments& look,
                    FrameOptions& frame);
// The groups View (the camera), Light and Drawing (what a picture shows).
void addViewOptions(CLI::App& app, const AskedView& asked, FrameOptions& options);
// The rest of the group Drawing: how a frame comes about.
void addFrameOptions(CLI::App& app, const AskedView& asked, FrameOptions& options);
// --time-limit, not for benches: a frame that ends at its limit measures the limit.
void addTimeLimit(CLI::App& app, const AskedView& asked, FrameOptions& options);
// Look, view and fit of the commands that choose a good first picture.
AskedView addPictureOptions(CLI::App& app, LookArguments& look, FrameOptions& frame,
                            FitChoice& fit);
// Sets `frame.cut` to the cut that is asked for: the default, voxels as wide as pixels, without any
// of these options.
void addLevelOptions(CLI::App& app, const AskedView& asked, FrameOptions& frame,
                     ResourceArguments& resources);
// The group of memory and device, for commands that draw as `render` does.
void addResourceOptions(CLI::App& app, ResourceArguments& arguments);
// The part of it for commands that only read a volume and its index.
void addReadingOptions(CLI::App& app, ResourceArguments& arguments);
// Takes those options of drawing that the command does not have, for scripts that give the same
// ones to several commands. No help lists them, and each that is given is a warning. To be called
// last.
void takeIdleOptions(CLI::App& app);

// "64x32x32" as --page takes it, no longer than a block along any axis; nullopt: something else.
std::optional<Vec3i> parsePageOption(const std::string& word);
inline constexpr const char* kPageSizes = "powers of two AxBxC, each from 1 to 1024";

// The cut that a picture of these options is drawn from, within the memory: the one that
// `frame.cut` asks for. Unset: the finest level, asked for or because the default does not apply.
std::optional<CutOptions> cutOptions(const ResourceArguments& resources, const LookArguments& look,
                                     const FrameOptions& frame, PictureRow row);
// Throws Error with this reason if anything but the finest level is asked for.
void refuseLevels(const std::optional<CutOptions>& asked, std::string_view why);

// Some of the last group, for commands that take no more.
inline constexpr int64_t kMostFrames = 100'000;
void addLevelsOption(const OptionGroup& group, MachineOptions& machine);
void addThreadsOption(const OptionGroup& group, int& threads);
void addMemoryOption(const OptionGroup& group, MachineOptions& machine);
// --device and --gl.
void addDeviceOptions(const OptionGroup& group, DeviceArguments& arguments);
void addSimdOption(const OptionGroup& group, DeviceArguments& arguments);
// Pictures, or frames that are measured: int64_t or int.
template <class Number>
void addFramesOption(const OptionGroup& group, Number& frames, const std::string& help) {
  group.number("--frames", "N", frames, {1, kMostFrames}, help);
}
void addIndexDirOption(const OptionGroup& group, std::string& folder);
void addQuietOption(const OptionGroup& group, bool& quiet);
void addReportOption(const OptionGroup& group, std::string& file);
void addForceOption(const OptionGroup& group, bool& force);
void addJsonOption(const OptionGroup& group, bool& json,
                   const std::string& help = "One JSON object");

// An option that takes one of `types`, also by its long name ("uint8"). Target: VoxelType, or an
// optional of it.
template <class Target>
CLI::Option* addTypeOption(const OptionGroup& group, const std::vector<VoxelType>& types,
                           Target& target, const std::string& help) {
  const auto also = [types](const std::string& word) {
    const auto type = parseVoxelType(word);
    return type && std::find(types.begin(), types.end(), *type) != types.end() ? type
                                                                               : std::nullopt;
  };
  return group.choice("--type",
                      wordsOf<VoxelType>(types, [](VoxelType type) { return name(type); }), target,
                      help, std::function<std::optional<VoxelType>(const std::string&)>(also));
}

inline constexpr const char* kOutputHeading = "Output";
inline constexpr const char* kSeriesHeading = "Series";
inline constexpr const char* kMachineHeading = "Memory and device";

}  // namespace sluice

// The table of options: how the file of a volume is read.
#include "src/base/values/voxel_type.h"
#include "src/options/option_entries.h"

namespace sluice {
namespace {

using Form = OptionForm;

constexpr double kMostSkipBytes = 0x1p60, kMostSpacing = 1e12, kMostChannel = 1e6;

// The short name of a type: "u8" for "uint8".
std::optional<std::string_view> shortName(const std::string& word) {
  const std::optional<VoxelType> type = parseVoxelType(word);
  return type ? std::optional(name(*type)) : std::nullopt;
}

// The number of time steps is part of the option on a command line.
VolumeEntry inDims(VolumeEntry entry) {
  entry = inPart(OptionPart::kVolume, "", std::move(entry));
  entry.get = [](const VolumeOptions& options) -> std::optional<OptionValue> {
    if (!options.dims) return std::nullopt;
    OptionWholes n(options.dims->begin(), options.dims->end());
    if (options.time_steps) n.push_back(*options.time_steps);
    return n;
  };
  entry.set = [](VolumeOptions& options, const OptionValue& value) {
    const auto& n = std::get<OptionWholes>(value);
    options.dims = {n[0], n[1], n[2]};
    if (n.size() > 3) options.time_steps = n[3];
  };
  return entry;
}

// A number goes before a name.
VolumeEntry inChannel(VolumeEntry entry) {
  entry = inPart(OptionPart::kVolume, "", std::move(entry));
  entry.get = [](const VolumeOptions& options) {
    return options.channel ? readMember({}, options.channel) : readMember({}, options.channel_name);
  };
  entry.set = [](VolumeOptions& options, const OptionValue& value) {
    const auto* const number = std::get_if<int64_t>(&value);
    options.channel = number != nullptr ? std::optional(*number) : std::nullopt;
    options.channel_name = number != nullptr ? "" : std::get<std::string>(value);
  };
  return entry;
}

}  // namespace

std::vector<VolumeEntry> volumeEntries() {
  return {
      inDims({.key = "dims",
              .option = "--dims",
              .heading = kVolumeHeading,
              .kind = {Form::kDims, {1, kMostAlongAxis}, "a whole number"},
              .value = "X,Y,Z[,T]",
              .help = "Raw: voxels along each axis, and time steps"}),
      in(&VolumeOptions::type,
         {.key = "type",
          .option = "--type",
          .heading = kVolumeHeading,
          .kind = {.form = Form::kWord,
                   .words = {"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"},
                   .meant = shortName},
          .help = "Raw: voxel type"}),
      in(&VolumeOptions::big_endian, {.key = "big_endian",
                                      .option = "--endian",
                                      .heading = kVolumeHeading,
                                      .is_rare = true,
                                      .kind = {.form = Form::kFlag, .words = {"little", "big"}},
                                      .help = "Raw: byte order"}),
      in(&VolumeOptions::skip_bytes, {.key = "skip",
                                      .option = "--skip",
                                      .field = "skip_bytes",
                                      .heading = kVolumeHeading,
                                      .is_rare = true,
                                      .kind = {Form::kWhole, {0, kMostSkipBytes}, "a whole number"},
                                      .value = "BYTES",
                                      .help = "Raw: bytes before the voxels"}),
      in(&VolumeOptions::time_steps,
         {.key = "time_steps", .kind = {Form::kWhole, {1, kMostAlongAxis}, "a whole number"}}),
      in(&VolumeOptions::spacing, {.key = "spacing",
                                   .option = "--spacing",
                                   .heading = kVolumeHeading,
                                   .kind = {Form::kSpacing, {0, kMostSpacing, true}},
                                   .value = "X,Y,Z",
                                   .help = "World units between voxels, instead of the file's"}),
      in(&VolumeOptions::grid, {.key = "grid",
                                .option = "--grid",
                                .heading = kVolumeHeading,
                                .is_rare = true,
                                .kind = {Form::kName},
                                .value = "NAME",
                                .help = "OpenVDB: name of the grid; DICOM: number of the series"}),
      inChannel({.key = "channel",
                 .option = "--channel",
                 .heading = kVolumeHeading,
                 .kind = {Form::kChannel, {0, kMostChannel}, "a whole number"},
                 .value = "N|NAME,...",
                 .help = "Zarr, N5, HDF5, VTK, TIFF: channel by its number, from 0 (the first), or "
                         "by its name in the file; pictures show several together (the active ones "
                         "of an OME file, else the first)"}),
      // Commands that read a single volume have no --over.
      in(&VolumeOptions::over,
         {.key = "over",
          .option = "--over",
          .kind = {Form::kFile},
          .value = "SECOND",
          .help = "A second volume, drawn together with the first at its own place in the world, "
                  "such as labels over a scan; --look over:... gives its look"}),
  };
}

}  // namespace sluice

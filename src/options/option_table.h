// The options of a view and of its volume, each described once: its names, form and limits, and
// where a ViewState or VolumeOptions hold it. The following are derived from these tables: the
// saved view, the printed command and the checks (src/view/state), the command line with its help
// (tools/options), the keywords of the Python package with their types (python/picture_options.h),
// and the names of fields in messages of the library (src/library/option_fields.h). Pure functions.
//
// A new option is a member of the public options (include/sluice/options.h, volume.h), an entry in
// camera_entries.cpp, look_entries.cpp, picture_entries.cpp or volume_entries.cpp, and the place
// where its value is used.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "src/base/error.h"
#include "src/base/values/number_range.h"
#include "src/options/view_state.h"

namespace sluice {

using OptionReals = std::vector<double>;
using OptionWholes = std::vector<int64_t>;
// The value of an option, as JSON and a command line hold it.
using OptionValue = std::variant<bool, int64_t, double, std::string, OptionReals, OptionWholes,
                                 std::vector<OptionReals>, std::vector<std::string>>;

// The alternative of OptionValue is in parentheses.
enum class OptionForm {
  kFlag,       // a flag, or one of the two `words` for false and true (bool)
  kWhole,      // a whole number within the limits (int64_t)
  kBytes,      // as kWhole; a command line may give a unit, as in 512M
  kNumber,     // a number within the limits (double)
  kSeconds,    // as kNumber; a command line may give a unit, as in 500ms
  kWord,       // one of `words` (std::string)
  kText,       // (std::string)
  kFile,       // the name of a file (std::string)
  kName,       // a name of any bytes within a file (std::string)
  kChannel,    // a channel's number within the limits, or a kName (int64_t, std::string)
  kRange,      // two different numbers (OptionReals)
  kAngles,     // two numbers within the limits, in degrees (OptionReals)
  kPlace,      // three numbers within the limits: a world position (OptionReals)
  kDirection,  // as kPlace, not all 0 (OptionReals)
  kColor,      // three numbers from 0 to 1 (OptionReals)
  kSpacing,    // as kPlace, of each axis; a command line may give one number (OptionReals)
  kVoxel,      // three whole numbers within the limits (OptionWholes)
  kDims,       // as kVoxel; on a command line perhaps the time steps as a fourth (OptionWholes)
  kBox,        // the lower and the upper corner of a box of voxels (OptionWholes)
  kPoints,     // pairs of a value, ascending, and an opacity (a list of OptionReals)
  kPlanes,     // normal and offset each (a list of OptionReals)
  kSurfaces,   // surfaces, as parseSurfaceLook() takes each (a list of std::string)
  kLabels,     // looks of labels, as parseLabelLook() takes each (a list of std::string)
  kChannels,   // looks of channels, as parseChannelLook() takes them (a list of std::string)
};

// The numbers of a value, or of each list of kPoints and kPlanes; 0: it is no list.
size_t numbersOf(OptionForm form);

// The values that an option takes.
struct OptionKind {
  OptionForm form = OptionForm::kNumber;
  NumberRange<double> limits = {};
  std::string_view noun = "a number";  // of a value, in the messages of checks
  std::vector<std::string_view> words = {};
  // Gives the one of `words` that another word stands for, or nullopt. Null: no other word is
  // known.
  std::optional<std::string_view> (*meant)(const std::string& word) = nullptr;
  // The flags that stand for the words on a command line; empty: no flag says the word.
  std::vector<std::string_view> flags = {};
  std::string_view needs = {};  // a flag that the option is printed with
  // The value that the option alone stands for on a command line; empty: it needs one.
  std::string_view bare = {};
};

// The object of a saved view that an option is in: "camera", "look", or the view itself. kPicture:
// none; the option says how one picture is made, and views are saved and printed without it.
// kVolume: "volume"; the options of VolumeOptions, and no others.
enum class OptionPart { kCamera, kLook, kTop, kPicture, kVolume };

// The largest extent of a volume along an axis, in voxels.
inline constexpr int64_t kMostAlongAxis = int64_t{1} << 40;

// Headings of --help.
inline constexpr std::string_view kVolumeHeading = "Volume", kViewHeading = "View",
                                  kLookHeading = "Look",
                                  kPartsHeading = "Channels, labels, surfaces",
                                  kLightHeading = "Light", kDrawingHeading = "Drawing",
                                  kLevelsHeading = "Levels of resolution";

// `Subject`: the struct that holds the option's value.
template <class Subject>
struct EntryOf {
  const char* key = "";          // the name in that object
  std::string_view option = {};  // "--zoom"; empty: a command line has none
  // The member of the library's structs as messages name it: "view.zoom". An entry gives the last
  // part alone, and nothing if that is its key. Empty in the table: the library has no such member.
  std::string field = {};
  // Commands with all options of a part add those with a heading, under it. Empty: a command that
  // has the option adds it by itself.
  std::string_view heading = {};
  // The look that a picture is printed with has the option, in addition to those of the transfer
  // function: it changes the light or the samples of the picture.
  bool is_light = false;
  bool is_rare = false;  // left out of --help, but not of --help-all, of the commands that draw
  int turn = 0;          // printed commands have options in ascending order of turns
  OptionKind kind = {};
  // The value that stands for none, so that films can go from it to another one; nullopt: none has
  // a meaning of its own, or follows from the view or the volume.
  std::optional<OptionValue> unset = {};
  std::string_view value = {};  // the value's name in --help; empty if the words are listed
  std::string_view help = {};   // the line of --help; empty if the command line words it
  // Whether views are saved with the option, and whether commands are printed with one that is
  // saved. Null: always.
  bool (*is_saved)(const Subject&) = nullptr;
  bool (*is_printed)(const Subject&) = nullptr;
  OptionPart part = OptionPart::kTop;
  // nullopt: the subject does not set the option.
  std::function<std::optional<OptionValue>(const Subject&)> get = {};
  // Requires: the alternative is the form's, with as many numbers, and a word is one of `words`.
  std::function<void(Subject&, const OptionValue&)> set = {};
};
using OptionEntry = EntryOf<ViewState>;
using VolumeEntry = EntryOf<VolumeOptions>;

// All options of a view, part by part, and those of a volume, in the order in which a saved view is
// read.
const std::vector<OptionEntry>& optionTable();
const std::vector<VolumeEntry>& volumeTable();

// The entry of an option. Requires: there is one.
template <class Subject>
const EntryOf<Subject>& entryIn(const std::vector<EntryOf<Subject>>& table,
                                std::string_view option) {
  const auto found = std::ranges::find(table, option, &EntryOf<Subject>::option);
  SLUICE_CHECK(found != table.end());
  return *found;
}
inline const OptionEntry& optionEntry(std::string_view option) {
  return entryIn(optionTable(), option);
}

// All names that stand for the option on a command line, flags included: "--shade", "--no-shade".
template <class Subject>
std::vector<std::string_view> optionNames(const EntryOf<Subject>& entry) {
  std::vector<std::string_view> names;
  for (const std::string_view name : {entry.option, entry.kind.needs})
    if (!name.empty()) names.push_back(name);
  for (const std::string_view flag : entry.kind.flags)
    if (!flag.empty() && flag != entry.option) names.push_back(flag);
  return names;
}

// The value that a view is saved with; nullopt: it is saved without the option, as it is without
// the options of its volume that have their defaults.
template <class Subject>
std::optional<OptionValue> savedValue(const EntryOf<Subject>& entry, const Subject& subject) {
  if (entry.part == OptionPart::kPicture) return std::nullopt;
  if (entry.is_saved != nullptr && !entry.is_saved(subject)) return std::nullopt;
  std::optional<OptionValue> value = entry.get(subject);
  if (entry.part == OptionPart::kVolume && value == entry.get({})) return std::nullopt;
  return value;
}

}  // namespace sluice

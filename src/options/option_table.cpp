#include "src/options/option_table.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/options/option_entries.h"

namespace sluice {
namespace {

std::vector<OptionEntry> makeTable() {
  std::vector<OptionEntry> table = cameraEntries();
  for (const std::vector<OptionEntry>& more : {lookEntries(), pictureEntries()})
    table.insert(table.end(), more.begin(), more.end());
  return table;
}

}  // namespace

size_t numbersOf(OptionForm form) {
  switch (form) {
    case OptionForm::kRange:
    case OptionForm::kAngles:
    case OptionForm::kPoints:
      return 2;
    case OptionForm::kPlace:
    case OptionForm::kDirection:
    case OptionForm::kColor:
    case OptionForm::kVoxel:
      return 3;
    case OptionForm::kPlanes:
      return 4;
    case OptionForm::kBox:
      return 6;
    default:
      return 0;
  }
}

const std::vector<OptionEntry>& optionTable() {
  static const std::vector<OptionEntry> table = makeTable();
  return table;
}

const OptionEntry& optionEntry(std::string_view option) {
  const auto& table = optionTable();
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const OptionEntry& entry) { return entry.option == option; });
  SLUICE_CHECK(found != table.end());
  return *found;
}

std::vector<std::string_view> optionNames(const OptionEntry& entry) {
  std::vector<std::string_view> names;
  for (const std::string_view name : {entry.option, entry.kind.needs})
    if (!name.empty()) names.push_back(name);
  for (const std::string_view flag : entry.kind.flags)
    if (!flag.empty() && flag != entry.option) names.push_back(flag);
  return names;
}

std::optional<OptionValue> savedValue(const OptionEntry& entry, const ViewState& state) {
  if (entry.part == OptionPart::kPicture) return std::nullopt;
  if (entry.is_saved != nullptr && !entry.is_saved(state)) return std::nullopt;
  return entry.get(state);
}

}  // namespace sluice

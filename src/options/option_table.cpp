#include "src/options/option_table.h"

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
    case OptionForm::kSpacing:
    case OptionForm::kVoxel:
    case OptionForm::kDims:
      return 3;
    case OptionForm::kPlanes:
      return 4;
    case OptionForm::kBox:
      return 6;
      // The others are lists of any length, or are no numbers.
    default:
      return 0;
  }
}

// Made at the first call and never changed, so that all threads may read it.
const std::vector<OptionEntry>& optionTable() {
  static const std::vector<OptionEntry> table = makeTable();
  return table;
}

const std::vector<VolumeEntry>& volumeTable() {
  static const std::vector<VolumeEntry> table = volumeEntries();
  return table;
}

}  // namespace sluice

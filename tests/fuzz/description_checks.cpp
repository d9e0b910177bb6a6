#include "tests/fuzz/description_checks.h"

#include <cmath>
#include <string_view>

#include "src/base/error.h"

namespace sluice {
namespace {

void checkLine(std::string_view line) {
  SLUICE_CHECK(!line.empty() && line.size() < 1000);
  // Text from the header must not reach a terminal as it is; UTF-8 in file names may.
  for (const char c : line) SLUICE_CHECK((c >= ' ' && c != '\x7f') || c < 0);
}

void checkLayout(const VolumeLayout& layout) {
  SLUICE_CHECK_LT(0, checkedVolumeBytes("", layout));
  for (int axis = 0; axis < 3; ++axis) {
    const size_t a = static_cast<size_t>(axis);
    SLUICE_CHECK(layout.spacing[axis] > 0 && std::isfinite(layout.spacing[axis]));
    SLUICE_CHECK(std::isfinite(layout.origin[axis]));
    SLUICE_CHECK(std::abs(length(layout.axes[a]) - 1) < 1e-6);
  }
  SLUICE_CHECK(std::isfinite(layout.value_offset) && layout.value_scale != 0);
  if (layout.stored_range) SLUICE_CHECK_LE(layout.stored_range->lo, layout.stored_range->hi);
}

void checkFiles(const VolumeDescription& description) {
  SLUICE_CHECK(description.line_skip >= 0);
  SLUICE_CHECK(description.byte_skip >= VolumeDescription::kSkipToEnd);
  SLUICE_CHECK_LE(description.byte_skip, kMostSkipBytes);
  if (description.files.attached()) return;
  const int64_t count = description.files.count();
  SLUICE_CHECK_LT(0, count);
  const VolumeLayout& layout = description.layout;
  SLUICE_CHECK_EQ(volume(layout.dims) * layout.time_steps % count, 0);
  for (const int64_t index : {int64_t{0}, count / 2, count - 1})
    SLUICE_CHECK(!description.files.name(index).empty());
}

}  // namespace

void checkParser(const std::function<VolumeDescription()>& parse) {
  try {
    const VolumeDescription description = parse();
    checkLayout(description.layout);
    checkFiles(description);
    sizeArithmetic(description.layout, description.byte_skip);
  } catch (const Error& error) {
    checkLine(error.what());
  }
}

}  // namespace sluice

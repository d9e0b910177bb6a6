#include "io/zarr/metadata/zarr_times.h"

#include <fmt/format.h>

#include <cmath>

#include "src/base/files/json_field.h"

namespace sluice {

void placeSteps(const ZarrImage& image, const std::string& path, ZarrView& view) {
  if (!view.time || view.layout.time_steps < 2) return;
  const size_t axis = *view.time;
  TimeAxis times;
  if (!image.axes.empty()) times.unit = printable(image.axes[axis].unit);
  if (!image.scale.empty()) {
    times.step = image.scale[axis];
    times.start = image.translation[axis];
  }
  const auto note = [&](const char* what, double said, double used) {
    view.notes.push_back(fmt::format("{}: its {} along the axis of time is {}: {:g}{} is used",
                                     path, what, said, used,
                                     times.unit.empty() ? "" : " " + times.unit));
    return used;
  };
  // Products of several transformations may be infinite.
  if (!std::isfinite(times.step) || times.step <= 0) times.step = note("scale", times.step, 1);
  if (!std::isfinite(times.start)) times.start = note("translation", times.start, 0);
  if (times != TimeAxis()) view.times = times;
}

}  // namespace sluice

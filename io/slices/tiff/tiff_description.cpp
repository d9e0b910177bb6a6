#include "io/slices/tiff/tiff_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "io/files/length_unit.h"
#include "io/slices/description_numbers.h"
#include "io/slices/ome_description.h"

namespace sluice {
namespace {

Fields imageJFields(std::string_view text) {
  Fields fields;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, std::min(text.find('\n'), text.size()));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    std::string_view value = line.substr(equals + 1);
    while (!value.empty() && value.back() == '\r') value.remove_suffix(1);
    fields.emplace(line.substr(0, equals), value);
  }
  return fields;
}

void setImageJSpacing(const Fields& fields, double pixels_x, double pixels_y, PageOrder& order) {
  order.unit = lengthUnit(fieldOf(fields, "unit"));
  // Pixels without a unit have no size, but slices may be several pixels apart.
  if (order.unit.empty() && fieldOf(fields, "spacing").empty()) return;
  if (pixels_x > 0) order.spacing.x = lengthOr1(1 / pixels_x);
  order.spacing.y = pixels_y > 0 ? lengthOr1(1 / pixels_y) : order.spacing.x;
  const auto depth = numberIn<double>(fieldOf(fields, "spacing"));
  order.spacing.z = lengthOr1(depth ? std::optional(std::abs(*depth)) : std::nullopt);
  // ImageJ names the units of y and z only if they differ from that of x.
  const auto ratioOf = [&](const char* key) {
    return unitRatio(lengthUnit(fieldOf(fields, key)), order.unit);
  };
  order.spacing.y *= ratioOf("yunit");
  order.spacing.z *= ratioOf("zunit");
}

// ImageJ gives the pixel that lies at the world's origin, along each axis. Its numbers are the same
// if y is said to grow upward ("inverty"), because the world's y grows down the rows here.
void setImageJOrigin(const Fields& fields, PageOrder& order) {
  for (int a = 0; a < 3; ++a) {
    constexpr const char* kKeys[] = {"xorigin", "yorigin", "zorigin"};
    const double at = numberIn<double>(fieldOf(fields, kKeys[a])).value_or(0) * order.spacing[a];
    if (std::abs(at) <= kFarthest) order.origin[a] = 0 - at;  // no -0
    order.tells_place = order.tells_place || fields.contains(kKeys[a]);
  }
}

PageOrder imageJOrder(std::string_view text, int64_t pages, double pixels_x, double pixels_y) {
  const Fields fields = imageJFields(text);
  PageOrder order;
  order.channels = countOf(fields, "channels");
  order.slices = countOf(fields, "slices");
  order.frames = countOf(fields, "frames");
  const int64_t images = countOf(fields, "images");
  // A plain stack names images alone.
  if (planesOf(order) == 1) order.slices = images;
  const int64_t planes = planesOf(order);
  if (pages == 1 && planes > 1 && planes == images) {
    order.untold_pages = planes - 1;
  } else if (planes != pages) {
    const std::string said =
        fmt::format("its ImageJ description names {} channels x {} slices x {} frames",
                    order.channels, order.slices, order.frames);
    order = plainPages(pages);
    if (pages > 1)
      order.notes.push_back(
          fmt::format("{}, the file has {} pages, which are read as slices", said, pages));
  }
  order.channel_step = 1;
  order.slice_step = order.channels;
  order.frame_step = order.channels * order.slices;
  setImageJSpacing(fields, pixels_x, pixels_y, order);
  setImageJOrigin(fields, order);
  return order;
}
}  // namespace

PageOrder parseTiffDescription(std::string_view description, int64_t pages, double pixels_a_unit_x,
                               double pixels_a_unit_y) {
  if (description.starts_with("ImageJ="))
    return imageJOrder(description, pages, pixels_a_unit_x, pixels_a_unit_y);
  const bool is_ome = description.find("<OME") != std::string_view::npos ||
                      description.find(":OME") != std::string_view::npos;
  if (is_ome) return parseOmeDescription(description, pages);
  return plainPages(pages);
}

}  // namespace sluice

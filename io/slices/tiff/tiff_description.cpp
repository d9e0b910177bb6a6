#include "io/slices/tiff/tiff_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

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
  const auto depth = numberOfField<double>(fields, "spacing");
  order.spacing.z = lengthOr1(depth ? std::optional(std::abs(*depth)) : std::nullopt);
  if (depth && order.spacing.z != std::abs(*depth))
    order.notes.push_back(fmt::format(
        "its ImageJ description has a spacing of {:g}, which is no length: 1 is used", *depth));
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
    const double at = numberOfField<double>(fields, kKeys[a]).value_or(0) * order.spacing[a];
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
  // More than ImageJ shows together. tifffile calls the slices of an array without named axes
  // channels.
  constexpr int64_t kMostChannels = 8;
  if (order.channels > kMostChannels && order.slices == 1 && order.frames == 1) {
    order.notes.push_back(fmt::format(
        "its ImageJ description names {} channels of one slice, which are read as slices: tifffile "
        "writes so without metadata={{'axes': 'ZYX'}}",
        order.channels));
    order.slices = std::exchange(order.channels, 1);
  }
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
  setFrameTimes("its ImageJ description", fields, "finterval", "tunit", order);
  setImageJSpacing(fields, pixels_x, pixels_y, order);
  setImageJOrigin(fields, order);
  return order;
}

// The axes of an array that tifffile wrote, without those of a page.
struct ShapedAxes {
  std::vector<int64_t> extents;
  std::string letters;  // one each, as "TZ"; empty: not told
  bool is_truncated = false;
};
// Nullopt: no such description.
std::optional<ShapedAxes> shapedAxes(std::string_view text) {
  if (!text.starts_with('{')) return std::nullopt;
  const auto document = nlohmann::json::parse(text, nullptr, false);
  if (!document.is_object()) return std::nullopt;
  const auto shape = document.find("shape"), axes = document.find("axes"),
             truncated = document.find("truncated");
  if (shape == document.end() || !shape->is_array()) return std::nullopt;
  ShapedAxes found;
  for (const auto& extent : *shape) {
    if (!extent.is_number_integer() || extent < 1 || extent > kMostPlanes) return std::nullopt;
    found.extents.push_back(extent.get<int64_t>());
  }
  const size_t count = found.extents.size();
  if (axes != document.end() && axes->is_string()) found.letters = axes->get<std::string>();
  if (found.letters.size() != count) found.letters.clear();
  // The axes of a page: rows, columns, and perhaps samples.
  const bool has_samples = found.letters.ends_with("YXS");
  const size_t of_page = has_samples ? 3 : 2;
  if (count < of_page) return std::nullopt;
  found.extents.resize(count - of_page);
  if (!found.letters.empty()) found.letters.resize(count - of_page);
  found.is_truncated = truncated != document.end() && *truncated == true;
  return found;
}

// Counts and steps by letters of the axes; false: there are others, or one twice.
bool setOrder(const ShapedAxes& axes, PageOrder& order) {
  int64_t step = 1;
  std::string taken;
  for (size_t a = axes.extents.size(); a-- > 0; step *= axes.extents[a]) {
    if (axes.extents[a] == 1) continue;
    if (axes.letters.empty() || taken.find(axes.letters[a]) != std::string::npos) return false;
    taken += axes.letters[a];
    const auto set = [&](int64_t& count, int64_t& planes_between) {
      count = axes.extents[a];
      planes_between = step;
    };
    switch (axes.letters[a]) {
      case 'Z':
        set(order.slices, order.slice_step);
        break;
      case 'C':
        set(order.channels, order.channel_step);
        break;
      case 'T':
        set(order.frames, order.frame_step);
        break;
      default:
        return false;
    }
  }
  return true;
}

PageOrder shapedOrder(const ShapedAxes& axes, int64_t pages) {
  int64_t planes = 1, long_axes = 0;
  for (const int64_t extent : axes.extents) {
    // Each is within kMostPlanes, so that the product of two is within 63 bits.
    planes = std::min(planes * extent, kMostPlanes + 1);
    long_axes += extent > 1 ? 1 : 0;
  }
  const bool is_truncated = axes.is_truncated && pages == 1 && planes <= kMostPlanes;
  const std::string said =
      fmt::format("its description gives {} pages, as {}", planes, fmt::join(axes.extents, " x "));
  if (planes != pages && !is_truncated) {
    PageOrder order = plainPages(pages);
    // Several arrays in one file, each with a description of its own.
    if (long_axes > 0 || pages > 1)
      order.notes.push_back(
          fmt::format("{}; the file has {}, which are read as slices", said, pages));
    return order;
  }
  PageOrder order;
  if (!setOrder(axes, order)) {
    order = plainPages(planes);
    if (long_axes > 1)
      order.notes.push_back(fmt::format(
          "{}, but does not tell which of these are slices, channels and time steps; all of them "
          "are read as slices",
          said));
  }
  if (is_truncated) order.untold_pages = planes - 1;
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
  if (const auto axes = shapedAxes(description)) return shapedOrder(*axes, pages);
  return plainPages(pages);
}

}  // namespace sluice

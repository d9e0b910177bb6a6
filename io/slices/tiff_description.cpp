#include "io/slices/tiff_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "io/files/length_unit.h"

namespace sluice {
namespace {

constexpr int64_t kMostPages = 100'000'000;

template <class T>
std::optional<T> numberIn(std::string_view text) {
  T value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// The length when it makes sense as one, else 1.
double lengthOr1(std::optional<double> length) {
  constexpr double kLeast = 1e-15, kMost = 1e15;
  return length && *length >= kLeast && *length <= kMost ? *length : 1;
}

// ImageJ's "key=value" lines, or the attributes of an XML element.
using Fields = std::map<std::string, std::string, std::less<>>;

std::string fieldOf(const Fields& fields, std::string_view name) {
  const auto found = fields.find(name);
  return found == fields.end() ? "" : found->second;
}

// A count of 1 or more; 1 if the field is missing or makes no sense.
int64_t countOf(const Fields& fields, std::string_view name) {
  const auto count = numberIn<int64_t>(fieldOf(fields, name));
  return count && *count >= 1 && *count <= kMostPages ? *count : 1;
}

PageOrder plainPages(int64_t pages) {
  PageOrder order;
  order.slices = pages;
  return order;
}

int64_t planesOf(const PageOrder& order) {
  int64_t planes = order.slices;
  for (const int64_t factor : {order.channels, order.frames})
    if (__builtin_mul_overflow(planes, factor, &planes) || planes > kMostPages) return -1;
  return planes;
}

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
  order.unit = lengthUnit(fieldOf(fields, "unit"));
  if (order.unit.empty()) return order;
  if (pixels_x > 0) order.spacing.x = lengthOr1(1 / pixels_x);
  order.spacing.y = pixels_y > 0 ? lengthOr1(1 / pixels_y) : order.spacing.x;
  const auto depth = numberIn<double>(fieldOf(fields, "spacing"));
  order.spacing.z = lengthOr1(depth ? std::optional(std::abs(*depth)) : std::nullopt);
  return order;
}

// The attributes of the element that begins at `at`, which is its '<'.
Fields attributesAt(std::string_view xml, size_t at) {
  Fields fields;
  std::string_view tag = xml.substr(at, std::min(xml.find('>', at), xml.size()) - at);
  for (size_t equals = tag.find('='); equals != std::string_view::npos; equals = tag.find('=')) {
    size_t begin = equals;
    while (begin > 0 && tag[begin - 1] != ' ' && tag[begin - 1] != '\n' && tag[begin - 1] != '\t')
      --begin;
    if (equals + 1 >= tag.size() || (tag[equals + 1] != '"' && tag[equals + 1] != '\'')) break;
    const size_t end = tag.find(tag[equals + 1], equals + 2);
    if (end == std::string_view::npos) break;
    fields.emplace(tag.substr(begin, equals - begin), tag.substr(equals + 2, end - equals - 2));
    tag.remove_prefix(end + 1);
  }
  return fields;
}

// The position at which an element of this name begins, whatever its namespace; npos when there is
// none.
size_t elementFrom(std::string_view xml, std::string_view name, size_t from) {
  for (size_t at = xml.find(name, from); at != std::string_view::npos;
       at = xml.find(name, at + 1)) {
    const size_t end = at + name.size();
    const bool ends = end < xml.size() && (xml[end] == ' ' || xml[end] == '>' || xml[end] == '/' ||
                                           xml[end] == '\n' || xml[end] == '\t');
    const size_t open = xml.rfind('<', at);
    if (!ends || open == std::string_view::npos) continue;
    const std::string_view prefix = xml.substr(open + 1, at - open - 1);
    if (prefix.empty() || (prefix.back() == ':' && prefix.find_first_of(" />") == prefix.npos))
      return open;
  }
  return std::string_view::npos;
}

// The next element of this name behind the one that begins at `at`.
size_t elementAfter(std::string_view xml, std::string_view name, size_t at) {
  const size_t end = xml.find('>', at);
  return end == std::string_view::npos ? end : elementFrom(xml, name, end);
}

// The steps of the three axes in the order that letters such as "XYZCT" give.
bool setSteps(std::string_view letters, PageOrder& order) {
  if (letters.size() != 5 || !letters.starts_with("XY")) return false;
  int64_t step = 1;
  bool seen[3] = {};
  for (const char axis : letters.substr(2)) {
    const size_t which = axis == 'Z' ? 0 : axis == 'C' ? 1 : 2;
    if ((axis != 'Z' && axis != 'C' && axis != 'T') || seen[which]) return false;
    seen[which] = true;
    (which == 0 ? order.slice_step : which == 1 ? order.channel_step : order.frame_step) = step;
    step *= which == 0 ? order.slices : which == 1 ? order.channels : order.frames;
  }
  return true;
}

// Orders the pages if <TiffData> blocks put the planes out of order. False when the blocks do not
// name each plane once, in this file.
bool setPages(std::string_view pixels, int64_t pages, PageOrder& order) {
  std::vector<int64_t> page_of(static_cast<size_t>(pages), -1);
  bool any = false;
  for (size_t at = elementFrom(pixels, "TiffData", 0); at != std::string_view::npos;
       at = elementAfter(pixels, "TiffData", at)) {
    const Fields block = attributesAt(pixels, at);
    const auto numberOr = [&](std::string_view name, int64_t otherwise) {
      const std::string text = fieldOf(block, name);
      return text.empty() ? otherwise : numberIn<int64_t>(text).value_or(-1);
    };
    any = true;
    const int64_t first_page = numberOr("IFD", 0);
    const bool says_page = block.count("IFD") > 0;
    const int64_t count = numberOr("PlaneCount", says_page ? 1 : pages);
    const int64_t z = numberOr("FirstZ", 0), c = numberOr("FirstC", 0), t = numberOr("FirstT", 0);
    if (z < 0 || z >= order.slices || c < 0 || c >= order.channels || t < 0 || t >= order.frames ||
        first_page < 0 || count < 1 || count > pages)
      return false;
    const int64_t first = z * order.slice_step + c * order.channel_step + t * order.frame_step;
    for (int64_t i = 0; i < count; ++i) {
      if (first + i >= pages || first_page + i >= pages) return false;
      page_of[static_cast<size_t>(first + i)] = first_page + i;
    }
  }
  if (!any) return true;
  if (std::find(page_of.begin(), page_of.end(), -1) != page_of.end()) return false;
  order.pages = std::move(page_of);
  return true;
}

double omeLength(const Fields& pixels, std::string_view axis, const std::string& unit) {
  const std::string name = fmt::format("PhysicalSize{}", axis);
  const auto size = numberIn<double>(fieldOf(pixels, name));
  const std::string own = fieldOf(pixels, name + "Unit");
  // If y or z has another unit than x, a known unit is converted to x's.
  static const std::map<std::string, double, std::less<>> kMeters = {
      {"angstrom", 1e-10},  {"nanometer", 1e-9}, {"micrometer", 1e-6}, {"millimeter", 1e-3},
      {"centimeter", 1e-2}, {"meter", 1},        {"inch", 0.0254}};
  const auto from = kMeters.find(own.empty() ? "micrometer" : lengthUnit(own));
  const auto to = kMeters.find(unit);
  const bool known = from != kMeters.end() && to != kMeters.end();
  if (!size) return 1;
  return lengthOr1(known && from != to ? *size * from->second / to->second : *size);
}

// A signed number of 32 bits: red, green, blue and alpha from the highest byte down. Writers that
// do not choose a color write -1, white, which tells no channel from another.
std::optional<std::array<double, 3>> omeColor(const std::string& text) {
  int64_t number = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || status != std::errc() || end != text.data() + text.size() ||
      number < INT32_MIN || number > UINT32_MAX)
    return std::nullopt;
  const auto rgba = static_cast<uint32_t>(number);
  if (rgba == UINT32_MAX) return std::nullopt;
  return std::array{(rgba >> 24) / 255.0, (rgba >> 16 & 255) / 255.0, (rgba >> 8 & 255) / 255.0};
}

PageOrder omeOrder(std::string_view xml, int64_t pages) {
  const size_t at = elementFrom(xml, "Pixels", 0);
  if (at == std::string_view::npos) return plainPages(pages);
  const Fields pixels = attributesAt(xml, at);
  const size_t end = std::min(xml.find("Pixels>", at), xml.size());
  const std::string_view inside = xml.substr(at, end - at);
  PageOrder order;
  order.slices = countOf(pixels, "SizeZ");
  order.channels = countOf(pixels, "SizeC");
  order.frames = countOf(pixels, "SizeT");
  // Colors of one page are channels that take no pages.
  if (const size_t channel = elementFrom(inside, "Channel", 0); channel != std::string_view::npos) {
    const int64_t samples = countOf(attributesAt(inside, channel), "SamplesPerPixel");
    if (samples > 1 && order.channels % samples == 0) order.channels /= samples;
  }
  if (planesOf(order) != pages || !setSteps(fieldOf(pixels, "DimensionOrder"), order) ||
      !setPages(inside, pages, order)) {
    const std::string said =
        fmt::format("its OME description names {} slices x {} channels x {} steps", order.slices,
                    order.channels, order.frames);
    order = plainPages(pages);
    order.notes.push_back(fmt::format(
        "{}, but this file has {} pages (a set of several files?); its pages are read as slices",
        said, pages));
  }
  bool says_colors = false;
  for (size_t c = elementFrom(inside, "Channel", 0);
       c != std::string_view::npos &&
       static_cast<int64_t>(order.channel_names.size()) < order.channels;
       c = elementAfter(inside, "Channel", c)) {
    const Fields channel = attributesAt(inside, c);
    order.channel_names.push_back(fieldOf(channel, "Name"));
    order.channel_looks.push_back({.color = omeColor(fieldOf(channel, "Color"))});
    says_colors = says_colors || order.channel_looks.back().color;
  }
  if (!says_colors) order.channel_looks.clear();
  if (fieldOf(pixels, "PhysicalSizeX").empty()) return order;
  const std::string unit = fieldOf(pixels, "PhysicalSizeXUnit");
  order.unit = unit.empty() ? "micrometer" : lengthUnit(unit);
  order.spacing = {omeLength(pixels, "X", order.unit), omeLength(pixels, "Y", order.unit),
                   omeLength(pixels, "Z", order.unit)};
  return order;
}

}  // namespace

PageOrder parseTiffDescription(std::string_view description, int64_t pages, double pixels_a_unit_x,
                               double pixels_a_unit_y) {
  if (description.starts_with("ImageJ="))
    return imageJOrder(description, pages, pixels_a_unit_x, pixels_a_unit_y);
  const bool is_ome = description.find("<OME") != std::string_view::npos ||
                      description.find(":OME") != std::string_view::npos;
  if (is_ome) return omeOrder(description, pages);
  return plainPages(pages);
}

}  // namespace sluice

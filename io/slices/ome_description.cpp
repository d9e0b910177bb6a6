#include "io/slices/ome_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "io/files/length_unit.h"
#include "io/files/xml_scanner.h"
#include "io/slices/description_numbers.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"

namespace sluice {
namespace {

// A <TiffData> block: planes one after the other from this one on, in pages one after the other.
struct TiffBlock {
  Fields fields;
  std::string file;  // empty: the file that has the description
};

struct OmePixels {
  bool was_found = false;
  Fields fields;
  std::vector<Fields> channels;
  std::vector<TiffBlock> blocks;
  std::string companion;
  Fields first_plane;                              // <Plane> of slice, channel and step 0
  std::vector<std::pair<int64_t, double>> depths;  // slice and PositionZ, of channel and step 0
};

Fields fieldsOf(const XmlTag& tag) {
  Fields fields;
  for (const auto& [name, value] : tag.attributes) fields.emplace(name, value);
  return fields;
}

// Keeps the place of a plane of the first channel and step.
void addPlane(const Fields& plane, OmePixels& pixels) {
  const auto numberOf = [&](std::string_view name) {
    return numberOfField<int64_t>(plane, name).value_or(-1);
  };
  const int64_t slice = numberOf("TheZ");
  // A volume has one place, for all of its channels and steps.
  if (numberOf("TheC") != 0 || numberOf("TheT") != 0 || slice < 0) return;
  if (slice == 0) pixels.first_plane = plane;
  if (const auto depth = numberOfField<double>(plane, "PositionZ"))
    pixels.depths.emplace_back(slice, *depth);
}

// Throws Error.
OmePixels pixelsIn(std::string_view xml) {
  OmePixels pixels;
  bool is_inside = false;
  const auto input = [&](uint64_t offset, std::span<std::byte> out) {
    const size_t count = std::min<uint64_t>(out.size(), xml.size() - std::min(offset, xml.size()));
    if (count > 0) std::memcpy(out.data(), xml.data() + offset, count);
    return count;
  };
  const auto begin = [&](const XmlTag& tag) {
    // Writers choose a prefix of the namespace as they like, such as "ome:Pixels".
    const std::string_view name = tag.name.substr(tag.name.find(':') + 1);
    if (name == "BinaryOnly") pixels.companion = fieldOf(fieldsOf(tag), "MetadataFile");
    if (name == "Pixels") {
      // Only the first image of a file is read; stopping here spares a long description.
      if (pixels.was_found) return false;
      pixels.was_found = is_inside = true;
      pixels.fields = fieldsOf(tag);
    }
    if (!is_inside) return true;
    if (name == "Channel") pixels.channels.push_back(fieldsOf(tag));
    if (name == "TiffData") pixels.blocks.push_back({fieldsOf(tag), ""});
    if (name == "Plane") addPlane(fieldsOf(tag), pixels);
    if (name == "UUID" && !pixels.blocks.empty())
      pixels.blocks.back().file = fieldOf(fieldsOf(tag), "FileName");
    return true;
  };
  const auto end = [&](std::string_view name, uint64_t /*at*/) {
    if (name.substr(name.find(':') + 1) == "Pixels") is_inside = false;
  };
  scanXml(input, "its OME description", {begin, end, {}});
  return pixels;
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

// The files that the blocks name; empty if they name no more than one, which is this file whatever
// it is called now.
std::vector<std::string> filesOf(const std::vector<TiffBlock>& blocks) {
  std::vector<std::string> files;
  for (const TiffBlock& block : blocks)
    if (std::find(files.begin(), files.end(), block.file) == files.end())
      files.push_back(block.file);
  if (files.size() < 2) files.clear();
  return files;
}

// Places the planes as the blocks say. False if they do not name each plane once.
bool placePlanes(const std::vector<TiffBlock>& blocks, int64_t pages, PageOrder& order) {
  // Without blocks, pages follow DimensionOrder one by one.
  if (blocks.empty()) return planesOf(order) == pages;
  constexpr int64_t kMostOfSet = 1'000'000;
  const int64_t planes = planesOf(order);
  const bool is_set = !order.files.empty();
  // SizeZ, SizeC and SizeT are text of the file: their product is an allocation below.
  if (is_set ? planes < 1 || planes > kMostOfSet : planes != pages) return false;
  constexpr PagePlace kNowhere{0, -1};
  std::vector<PagePlace> places(static_cast<size_t>(planes), kNowhere);
  for (const TiffBlock& block : blocks) {
    const auto numberOr = [&](std::string_view name, int64_t otherwise) {
      const std::string text = fieldOf(block.fields, name);
      return text.empty() ? otherwise : numberOfField<int64_t>(block.fields, name).value_or(-1);
    };
    const int64_t page = numberOr("IFD", 0);
    const bool says_page = block.fields.count("IFD") > 0;
    // OME: without PlaneCount, IFD names one plane, and no IFD stands for all pages of the file.
    const int64_t count = numberOr("PlaneCount", says_page ? 1 : pages);
    const int64_t z = numberOr("FirstZ", 0), c = numberOr("FirstC", 0), t = numberOr("FirstT", 0);
    if (z < 0 || z >= order.slices || c < 0 || c >= order.channels || t < 0 || t >= order.frames ||
        page < 0 || page > kMostPlanes || count < 1)
      return false;
    const int64_t first = order.plane(t, z, c);
    // Neither the list of planes nor, in a single file, the pages may be left.
    if (count > planes - first || (!is_set && count > pages - page)) return false;
    const auto file = std::find(order.files.begin(), order.files.end(), block.file);
    const auto number = static_cast<uint32_t>(is_set ? file - order.files.begin() : 0);
    for (int64_t i = 0; i < count; ++i) places[static_cast<size_t>(first + i)] = {number, page + i};
  }
  if (std::find(places.begin(), places.end(), kNowhere) != places.end()) return false;
  order.places = std::move(places);
  return true;
}

// nullopt: it is not given. If y or z has another unit than x, a known unit is converted to x's.
std::optional<double> omeLength(const Fields& pixels, std::string_view axis,
                                const std::string& unit) {
  const std::string name = fmt::format("PhysicalSize{}", axis);
  const auto size = numberOfField<double>(pixels, name);
  const std::string own = fieldOf(pixels, name + "Unit");
  if (!size) return std::nullopt;
  // OME's default unit of a physical size is the micrometer.
  return *size * unitRatio(own.empty() ? "micrometer" : lengthUnit(own), unit);
}

// The unit of a plane's position along an axis. The stage's own frame, which counts without a unit,
// has no length.
std::optional<double> unitsOfPosition(const Fields& plane, std::string_view axis,
                                      const std::string& unit) {
  const std::string own = lengthUnit(fieldOf(plane, fmt::format("Position{}Unit", axis)));
  if (!metersOf(own) || !metersOf(unit)) return std::nullopt;
  return unitRatio(own, unit);
}

// The distance between slices by the planes' positions; nullopt: they have no length or do not lie
// evenly.
std::optional<double> stepOfPlanes(const OmePixels& pixels, const PageOrder& order) {
  const auto units = unitsOfPosition(pixels.first_plane, "Z", order.unit);
  auto depths = pixels.depths;
  std::ranges::sort(depths);
  const auto count = static_cast<int64_t>(depths.size());
  if (!units || count < 2 || count != order.slices) return std::nullopt;
  const double step = (depths.back().second - depths.front().second) / double(count - 1);
  for (int64_t z = 0; z < count; ++z) {
    const auto& [slice, depth] = depths[static_cast<size_t>(z)];
    const double expected = depths.front().second + step * double(z);
    // A deviation of half a step would put a slice nearer to a neighbour's place; NaN fails as
    // well.
    if (slice != z || !(std::abs(depth - expected) < std::abs(step) / 2)) return std::nullopt;
  }
  return lengthOr1(std::abs(step * *units));
}

void setOmeSpacing(const OmePixels& pixels, PageOrder& order) {
  const auto lengthOf = [&](std::string_view axis) {
    const auto length = omeLength(pixels.fields, axis, order.unit);
    if (!length || lengthOr1(length) == *length) return length;
    order.notes.push_back(fmt::format(
        "its OME description has a PhysicalSize{} of {:g}, which is no length: 1 {} is used", axis,
        *length, order.unit));
    return std::optional(1.0);
  };
  const auto x = lengthOf("X"), y = lengthOf("Y"), z = lengthOf("Z"),
             planes = z ? std::nullopt : stepOfPlanes(pixels, order);
  order.spacing.x = x.value_or(1);
  order.spacing.y = y.value_or(order.spacing.x);
  order.spacing.z = z ? *z : planes.value_or(1);
  if (!z && !planes && order.slices > 1)
    order.spacing_fault = fmt::format(
        "its OME description has no PhysicalSizeZ: its slices are taken to be 1 {} apart; give "
        "--spacing X,Y,Z if they are not",
        order.unit);
}

// Places the first voxel where the stage was for the first plane.
void setOmeOrigin(const OmePixels& pixels, PageOrder& order) {
  Vec3d origin;
  for (int a = 0; a < 3; ++a) {
    const std::string axis(1, "XYZ"[a]), name = "Position" + axis;
    const double at = numberOfField<double>(pixels.first_plane, name).value_or(0);
    order.tells_place = order.tells_place || pixels.first_plane.contains(name);
    const auto units = unitsOfPosition(pixels.first_plane, axis, order.unit);
    if (at != 0 && !units) {
      const std::string said = fieldOf(pixels.first_plane, name + "Unit");
      order.place_fault = fmt::format(
          "its {} is in the unit '{}', which has no length: the positions in its OME description "
          "are not used",
          name, said.empty() ? "reference frame" : printable(said, kLongestName));
      return;
    }
    // The negation refuses NaN, too.
    if (!(std::abs(at * units.value_or(1)) <= kFarthest)) {
      order.place_fault =
          fmt::format("its {} is beyond {:g}: the positions in its OME description are not used",
                      name, kFarthest);
      return;
    }
    origin[a] = at * units.value_or(1);
  }
  // Pairs compare by their slices first.
  const auto by_slice = std::ranges::minmax_element(pixels.depths);
  if (!pixels.depths.empty() && by_slice.max->second < by_slice.min->second) {
    order.place_fault =
        "its PositionZ falls from slice to slice, against its axis z: the place along z is not "
        "used";
    origin.z = 0;
  }
  order.origin = origin;
}

// A signed number of 32 bits: red, green, blue and alpha from the highest byte down. Writers that
// do not choose a color write -1, white, which tells no channel from another.
std::optional<std::array<double, 3>> omeColor(const std::string& text) {
  const auto number = numberIn<int64_t>(trimmed(text));
  if (!number || *number < INT32_MIN || *number > UINT32_MAX) return std::nullopt;
  const auto rgba = static_cast<uint32_t>(*number);
  if (rgba == UINT32_MAX) return std::nullopt;
  return std::array{(rgba >> 24) / 255.0, (rgba >> 16 & 255) / 255.0, (rgba >> 8 & 255) / 255.0};
}

void describeChannels(const std::vector<Fields>& channels, PageOrder& order) {
  bool says_colors = false;
  for (const Fields& channel : channels) {
    if (static_cast<int64_t>(order.channel_names.size()) == order.channels) break;
    order.channel_names.push_back(printable(fieldOf(channel, "Name"), kLongestName));
    order.channel_looks.push_back({.color = omeColor(fieldOf(channel, "Color"))});
    says_colors = says_colors || order.channel_looks.back().color;
  }
  if (!says_colors) order.channel_looks.clear();
}

}  // namespace

PageOrder parseOmeDescription(std::string_view xml, int64_t pages) {
  OmePixels pixels;
  PageOrder order = plainPages(pages);
  try {
    pixels = pixelsIn(xml);
  } catch (const Error& error) {
    order.notes.push_back(fmt::format("{}; its pages are read as slices", error.what()));
    return order;
  }
  if (!pixels.was_found) {
    order.companion = pixels.companion;
    return order;
  }
  order.slices = countOf(pixels.fields, "SizeZ");
  order.channels = countOf(pixels.fields, "SizeC");
  order.frames = countOf(pixels.fields, "SizeT");
  // Colors of one page are channels that take no pages.
  if (!pixels.channels.empty()) {
    const int64_t samples = countOf(pixels.channels[0], "SamplesPerPixel");
    // SizeC counts the samples of each pixel, of which luminance makes one number here.
    if (samples > 1 && order.channels % samples == 0) order.channels /= samples;
  }
  order.files = filesOf(pixels.blocks);
  order.is_described = setSteps(fieldOf(pixels.fields, "DimensionOrder"), order) &&
                       placePlanes(pixels.blocks, pages, order);
  if (!order.is_described) {
    const std::string note = fmt::format(
        "its OME description names {} slices x {} channels x {} steps in {} files, but not a page "
        "for each; "
        "its own {} pages are read as slices",
        order.slices, order.channels, order.frames, std::max<size_t>(order.files.size(), 1), pages);
    order = plainPages(pages);
    order.notes.push_back(note);
  }
  describeChannels(pixels.channels, order);
  setFrameTimes("its OME description", pixels.fields, "TimeIncrement", "TimeIncrementUnit", order);
  if (fieldOf(pixels.fields, "PhysicalSizeX").empty()) return order;
  const std::string unit = fieldOf(pixels.fields, "PhysicalSizeXUnit");
  order.unit = unit.empty() ? "micrometer" : lengthUnit(unit);
  setOmeSpacing(pixels, order);
  setOmeOrigin(pixels, order);
  return order;
}

}  // namespace sluice

#include "io/headers/nrrd/nrrd_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "io/files/length_unit.h"
#include "io/headers/header_fields.h"
#include "io/headers/nrrd/nrrd_fields.h"
#include "src/base/error.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

constexpr int64_t kMaxDimension = 16;  // teem's NRRD_DIM_MAX

VoxelType voxelType(const NrrdFields& fields) {
  std::string text = withoutSpaces(fields.demand("type"));
  if (text.starts_with("signed")) text.erase(0, 6);
  if (text.starts_with("unsigned")) {
    text.erase(0, 7);
    text[0] = 'u';
  }
  // "unsigned short int" and "short" mean the same as in C.
  if (text.ends_with("shortint")) text.erase(text.size() - 3);
  if (const std::optional<VoxelType> type = parseVoxelType(text)) return *type;
  fail("{}: voxel type {} is not read; 8 to 32 bit integers, float and double are", fields.path,
       inQuotes(fields.demand("type")));
}

Encoding encoding(const NrrdFields& fields) {
  const std::string text = withoutSpaces(fields.demand("encoding"));
  if (text == "raw") return Encoding::kRaw;
  if (text == "gzip" || text == "gz") return Encoding::kDeflate;
  if (text == "txt" || text == "text" || text == "ascii") return Encoding::kText;
  fail("{}: encoding {} is not read; convert with 'unu save -f nrrd -e gzip'", fields.path,
       inQuotes(text));
}

std::endian byteOrder(const NrrdFields& fields, const VolumeDescription& description) {
  const std::optional<std::string_view> value = fields.find("endian");
  if (!value) {
    if (bytesPerVoxel(description.layout.type) > 1 && description.encoding != Encoding::kText)
      fail("{}: the NRRD header has no field 'endian', which {} voxels need", fields.path,
           name(description.layout.type));
    return std::endian::native;
  }
  const std::string text = lowercase(*value);
  if (text != "little" && text != "big")
    fail("{}: endian {} is neither 'little' nor 'big'", fields.path, inQuotes(*value));
  return text == "little" ? std::endian::little : std::endian::big;
}

int64_t integer(const NrrdFields& fields, std::string_view name, std::string_view text,
                int64_t least, int64_t most = std::numeric_limits<int64_t>::max()) {
  const std::optional<int64_t> value = parseInteger(text);
  if (!value || *value < least || *value > most)
    fail("{}: {}: {} is no whole number from {} to {}", fields.path, name, inQuotes(text), least,
         most);
  return *value;
}

double real(const NrrdFields& fields, std::string_view name, std::string_view text) {
  const std::optional<double> value = parseReal(text);
  if (!value) fail("{}: {}: {} is no number", fields.path, name, inQuotes(text));
  return *value;
}

std::vector<std::string_view> perAxis(const NrrdFields& fields, std::string_view name,
                                      std::string_view text, size_t dimension) {
  std::vector<std::string_view> words = splitWords(text);
  if (words.size() != dimension)
    fail("{}: {}: {} values, {} axes", fields.path, name, words.size(), dimension);
  return words;
}

// "(a, b, c)": at most three numbers count; a space with time has a fourth, which is no length.
Vec3d vector(const NrrdFields& fields, std::string_view name, std::string_view text) {
  std::string inner(trimmed(text));
  if (inner.size() < 2 || inner.front() != '(' || inner.back() != ')')
    fail("{}: {}: {} is no vector such as (1,0,0)", fields.path, name, inQuotes(text));
  inner = inner.substr(1, inner.size() - 2);
  std::replace(inner.begin(), inner.end(), ',', ' ');
  const std::vector<std::string_view> words = splitWords(inner);
  if (words.empty() || words.size() > 4)
    fail("{}: {}: {} has {} numbers, 1 to 4 expected", fields.path, name, inQuotes(text),
         words.size());
  Vec3d value;
  for (size_t i = 0; i < std::min<size_t>(words.size(), 3); ++i)
    value[static_cast<int>(i)] = real(fields, name, words[i]);
  return value;
}

// An axis of the array as the header describes it.
struct Axis {
  size_t number = 0;  // in the header
  int64_t size = 0;
  bool spatial = true;
  std::string kind;
  double spacing = 1;
  bool has_spacing = false;  // the header gives it
  double first = 0;          // the position of the first voxel's centre along the axis
  std::optional<Vec3d> direction;
};

void readSpacings(const NrrdFields& fields, std::span<Axis> axes) {
  const std::optional<std::string_view> text = fields.find("spacings");
  if (!text) return;
  const auto words = perAxis(fields, "spacings", *text, axes.size());
  for (size_t i = 0; i < axes.size(); ++i) {
    const double spacing = real(fields, "spacings", words[i]);
    // A spacing that is no number marks an axis that is not of space, such as time.
    axes[i].has_spacing = !std::isnan(spacing);
    if (axes[i].has_spacing)
      axes[i].spacing = spacing;
    else if (axes.size() > 3)
      axes[i].spatial = false;
  }
}

// The numbers of a field that has one for each axis; NaN if the field or the number is missing.
std::vector<double> realsPerAxis(const NrrdFields& fields, std::string_view field,
                                 std::string_view name, size_t dimension) {
  std::vector<double> values(dimension, std::numeric_limits<double>::quiet_NaN());
  const std::optional<std::string_view> text = fields.find(field);
  if (!text) return values;
  const auto words = perAxis(fields, name, *text, dimension);
  for (size_t i = 0; i < dimension; ++i) values[i] = real(fields, name, words[i]);
  return values;
}

// "axis mins" and "axis maxs" are the ends of an axis: the centres of its outer voxels if it is
// centred on nodes, else the outer faces of these voxels (teem's default). They give the spacing
// of an axis without "spacings". Requires: readSpacings has run.
void readEnds(const NrrdFields& fields, std::span<Axis> axes) {
  const std::vector<double> mins = realsPerAxis(fields, "axismins", "axis mins", axes.size());
  const std::vector<double> maxs = realsPerAxis(fields, "axismaxs", "axis maxs", axes.size());
  const std::vector<double> said = realsPerAxis(fields, "spacings", "spacings", axes.size());
  std::optional<std::string_view> text = fields.find("centers");
  if (!text) text = fields.find("centerings");
  std::vector<std::string_view> centers;
  if (text) centers = perAxis(fields, "centers", *text, axes.size());
  for (size_t i = 0; i < axes.size(); ++i) {
    Axis& axis = axes[i];
    const bool of_nodes = !centers.empty() && lowercase(centers[i]) == "node";
    const int64_t steps = of_nodes ? axis.size - 1 : axis.size;
    const double length = maxs[i] - mins[i];
    if (std::isnan(said[i]) && !std::isnan(length) && length != 0 && steps > 0) {
      axis.spacing = length / static_cast<double>(steps);
      axis.has_spacing = true;
    }
    if (!std::isnan(mins[i])) axis.first = of_nodes ? mins[i] : mins[i] + axis.spacing / 2;
  }
}

void readKinds(const NrrdFields& fields, std::span<Axis> axes) {
  const std::optional<std::string_view> text = fields.find("kinds");
  if (!text) return;
  const auto words = perAxis(fields, "kinds", *text, axes.size());
  for (size_t i = 0; i < axes.size(); ++i) {
    axes[i].kind = lowercase(words[i]);
    const bool of_space = axes[i].kind == "space" || axes[i].kind == "domain" ||
                          axes[i].kind == "none" || axes[i].kind == "???";
    if (!of_space) axes[i].spatial = false;
  }
}

void readDirections(const NrrdFields& fields, std::span<Axis> axes) {
  const std::optional<std::string_view> text = fields.find("spacedirections");
  if (!text) return;
  std::string_view rest = trimmed(*text);
  for (Axis& axis : axes) {
    const size_t end = rest.starts_with('(') ? std::min(rest.find(')'), rest.size() - 1) + 1
                                             : std::min(rest.find_first_of(" \t"), rest.size());
    const std::string_view item = rest.substr(0, end);
    rest = trimmed(rest.substr(end));
    if (item.empty())
      fail("{}: space directions: fewer vectors than the {} axes", fields.path, axes.size());
    if (item == "none")
      axis.spatial = false;
    else
      axis.direction = vector(fields, "space directions", item);
    // The time axis of a space such as "scanner-xyz-time".
    if (axis.direction == Vec3d{}) axis.spatial = false;
  }
  if (!rest.empty())
    fail("{}: space directions: more vectors than the {} axes", fields.path, axes.size());
}

std::vector<Axis> readAxes(const NrrdFields& fields) {
  const int64_t dimension =
      integer(fields, "dimension", fields.demand("dimension"), 1, kMaxDimension);
  std::vector<Axis> axes(static_cast<size_t>(dimension));
  const auto sizes = perAxis(fields, "sizes", fields.demand("sizes"), axes.size());
  for (size_t i = 0; i < axes.size(); ++i) {
    axes[i].number = i;
    axes[i].size = integer(fields, "sizes", sizes[i], 1);
  }
  readSpacings(fields, axes);
  readEnds(fields, axes);
  readKinds(fields, axes);
  readDirections(fields, axes);
  return axes;
}

// Removes the slowest axis if it counts time steps, and axes of one element that are not of space.
int64_t takeTimeSteps(const NrrdFields& fields, std::vector<Axis>& axes) {
  // Such an axis, for instance of one component, changes nothing.
  std::erase_if(axes, [](const Axis& axis) { return !axis.spatial && axis.size == 1; });
  int64_t steps = 1;
  if (!axes.empty() && (!axes.back().spatial || axes.size() == 4)) {
    steps = axes.back().size;
    axes.pop_back();
  }
  for (const Axis& axis : axes)
    if (!axis.spatial)
      fail(
          "{}: axis {} ({}) holds {} values a voxel; only volumes of one value per voxel are read "
          "(cut one out with 'unu slice -a {} -p 0')",
          fields.path, axis.number, axis.kind.empty() ? "not of space" : inQuotes(axis.kind),
          axis.size, axis.number);
  if (axes.size() > 3)
    fail("{}: {} axes of space, 3 and one of time at most", fields.path, axes.size());
  return steps;
}

// The world of a patient or none. Left-anterior-superior, the mirror image that few other programs
// know, is turned into right-anterior-superior.
void readFrame(const NrrdFields& fields, VolumeLayout& layout) {
  std::string space = withoutSpaces(fields.find("space").value_or(""));
  if (space.ends_with("-time")) space.resize(space.size() - 5);
  if (space.size() == 4 && space.back() == 't') space.pop_back();  // RAST, LAST, LPST
  if (space == "right-anterior-superior" || space == "ras") layout.frame = WorldFrame::kRas;
  if (space == "left-posterior-superior" || space == "lps") layout.frame = WorldFrame::kLps;
  if (space == "left-anterior-superior" || space == "las") {
    layout.frame = WorldFrame::kRas;
    layout.origin.x = 0 - layout.origin.x;  // no -0
    for (Vec3d& axis : layout.axes) axis.x = 0 - axis.x;
  }
}

// Words in quotation marks, as units of length.
std::vector<std::string> unitsIn(std::string_view text) {
  std::vector<std::string> units;
  for (size_t begin = text.find('"'); begin != std::string_view::npos;) {
    const size_t end = std::min(text.find('"', begin + 1), text.size());
    units.push_back(lengthUnit(text.substr(begin + 1, end - begin - 1)));
    begin = text.find('"', end + 1);
  }
  return units;
}

// The units of the world's x, y and z: "space units" if there is a space, else the "units" of the
// axes. A word that is missing is empty.
std::array<std::string, 3> worldUnits(const NrrdFields& fields, const std::vector<Axis>& axes) {
  std::array<std::string, 3> world;
  const auto of_space = fields.find("spaceunits"), of_axes = fields.find("units");
  const std::vector<std::string> said = unitsIn(of_space.value_or(of_axes.value_or("")));
  for (size_t i = 0; i < world.size(); ++i) {
    if (!of_space && i >= axes.size()) break;
    const size_t at = of_space ? i : axes[i].number;
    if (at < said.size()) world[i] = said[at];
  }
  return world;
}

// Says which spacings are odd: negative ones, and those that are not known although others are.
void noteSpacings(const NrrdFields& fields, const std::vector<Axis>& axes, VolumeLayout& layout) {
  std::vector<double> spacing;
  for (const Axis& axis : axes) {
    if (axis.direction) continue;
    spacing.push_back(axis.spacing);
    if (!axis.has_spacing && axis.size > 1 && fields.find("spacings"))
      layout.notes.push_back(
          fmt::format("{}: its spacing along axis {} is nan: its voxels are drawn 1 apart there",
                      fields.path, axis.number));
  }
  if (const std::string note = negativeSpacingNote(fields.path, spacing); !note.empty())
    layout.notes.push_back(note);
}

void readGeometry(const NrrdFields& fields, const std::vector<Axis>& axes, VolumeLayout& layout) {
  const std::array<std::string, 3> units = worldUnits(fields, axes);
  layout.unit = units[0];
  const auto inUnit = [&](Vec3d position) {
    for (int i = 0; i < 3; ++i)
      position[i] *= unitRatio(units[static_cast<size_t>(i)], layout.unit);
    return position;
  };
  std::vector<Vec3d> steps;
  Vec3d first;  // of the axes without a direction in the space
  for (size_t i = 0; i < axes.size(); ++i) {
    Vec3d step;
    step[static_cast<int>(i)] = axes[i].spacing;
    if (!axes[i].direction) first[static_cast<int>(i)] = axes[i].first;
    steps.push_back(inUnit(axes[i].direction.value_or(step)));
  }
  if (steps.empty()) steps.push_back({1, 0, 0});
  setSteps(fields.path, steps, layout);
  noteSpacings(fields, axes, layout);
  const std::optional<std::string_view> origin = fields.find("spaceorigin");
  const bool has_origin = origin && *origin != "none";
  setOrigin(fields.path, inUnit(has_origin ? vector(fields, "space origin", *origin) : first),
            layout);
  const auto least = fields.find("min"), greatest = fields.find("max");
  if (least && greatest)
    setStoredRange(fields.path, real(fields, "min", *least), real(fields, "max", *greatest),
                   layout);
  readFrame(fields, layout);
}

// The last word of a list or pattern: how many of the array's dimensions each file holds.
void demandFileCount(const NrrdFields& fields, const std::vector<Axis>& all, const FileSet& files,
                     std::optional<std::string_view> file_dimension) {
  const int64_t dimension = static_cast<int64_t>(all.size());
  const int64_t held = file_dimension ? integer(fields, "data file", *file_dimension, 1, dimension)
                                      : std::max<int64_t>(dimension - 1, 1);
  const int64_t count = files.count();
  if (held == dimension) {
    if (count < 1 || all.back().size % count != 0)
      fail("{}: {} data files do not share out the {} elements of the slowest axis evenly",
           fields.path, count, all.back().size);
    return;
  }
  int64_t wanted = 1;
  for (int64_t i = held; i < dimension; ++i)
    if (__builtin_mul_overflow(wanted, all[static_cast<size_t>(i)].size, &wanted))
      fail("{}: its sizes do not fit 63 bits", fields.path);
  if (count != wanted)
    fail("{}: {} data files of {} dimensions named, {} expected for its sizes", fields.path, count,
         held, wanted);
}

FileSet readFiles(const NrrdFields& fields, const std::vector<Axis>& axes) {
  FileSet files;
  const std::optional<std::string_view> text = fields.find("datafile");
  if (!text) {
    if (!fields.ended_by_blank_line)
      fail("{}: the header names no data file and no blank line ends it", fields.path);
    return files;
  }
  const std::vector<std::string_view> words = splitWords(*text);
  std::optional<std::string_view> held;
  if (listFollows(*text)) {
    for (const std::string_view name : fields.listed_files) addFileName(fields.path, name, files);
    if (words.size() > 1) held = words[1];
    if (files.names.empty()) fail("{}: 'data file: LIST' and no names after it", fields.path);
  } else if (words.size() >= 4 && words[0].find('%') != std::string_view::npos) {
    files = parseFilePattern(fields.path, words[0], words[1], words[2], words[3]);
    if (words.size() > 4) held = words[4];
  } else {
    addFileName(fields.path, *text, files);
    return files;
  }
  demandFileCount(fields, axes, files, held);
  return files;
}

}  // namespace

size_t nrrdHeaderBytes(std::string_view text) {
  const size_t unix_end = text.find("\n\n"), dos_end = text.find("\n\r\n");
  if (unix_end < dos_end) return unix_end + 2;
  return dos_end == std::string_view::npos ? dos_end : dos_end + 3;
}

VolumeDescription parseNrrdHeader(std::string_view text, const std::string& path) {
  const NrrdFields fields = readNrrdFields(text, path);
  VolumeDescription description;
  VolumeLayout& layout = description.layout;
  layout.type = voxelType(fields);
  description.encoding = encoding(fields);
  description.byte_order = byteOrder(fields, description);
  std::vector<Axis> axes = readAxes(fields);
  description.files = readFiles(fields, axes);
  description.data_offset = fields.header_bytes;
  layout.time_steps = takeTimeSteps(fields, axes);
  layout.dims = {1, 1, 1};
  for (size_t i = 0; i < axes.size(); ++i) layout.dims[static_cast<int>(i)] = axes[i].size;
  readGeometry(fields, axes, layout);
  noteUnknownFields(fields, layout);
  checkedVolumeBytes(path, layout);
  if (const auto lines = fields.find("lineskip"))
    description.line_skip = integer(fields, "line skip", *lines, 0);
  if (const auto bytes = fields.find("byteskip"))
    description.byte_skip = integer(fields, "byte skip", *bytes, -1, kMostSkipBytes);
  if (description.byte_skip == VolumeDescription::kSkipToEnd &&
      description.encoding != Encoding::kRaw)
    fail("{}: byte skip -1 needs encoding raw", path);
  return description;
}

}  // namespace sluice

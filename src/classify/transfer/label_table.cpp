#include "src/classify/transfer/label_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/files/number_text.h"
#include "src/base/files/text_file.h"
#include "src/base/values/text_parts.h"
#include "src/classify/transfer/color_maps.h"

namespace sluice {
namespace {

constexpr uint64_t kMostTableBytes = uint64_t{16} << 20;
constexpr const char* kExpectedLine =
    "NUMBER R G B A VISIBLE MESH \"NAME\" as ITK-SNAP writes it, or NUMBER NAME R G B A as 3D "
    "Slicer does, with whole numbers for the label and, from 0 to 255, for colours";

// The next word of the line, which is taken off.
std::string_view nextWord(std::string_view& rest) {
  rest = trimmed(rest);
  const std::string_view word = rest.substr(0, rest.find_first_of(" \t"));
  rest.remove_prefix(word.size());
  return word;
}

// The next number, from 0 to `most`; nullopt: there is none.
std::optional<double> nextNumber(std::string_view& rest, double most) {
  const std::optional<double> number = numberOf(nextWord(rest));
  return number && *number >= 0 && *number <= most ? number : std::nullopt;
}

// The next part of a colour, of 255. Fractions of 1 are not: 1.0 in a table of those means 255.
std::optional<double> nextByte(std::string_view& rest) {
  std::string_view ahead = rest;
  const std::string_view word = nextWord(ahead);
  const std::optional<double> number = nextNumber(rest, 255);
  const bool is_fraction =
      number && *number > 0 && *number <= 1 && word.find('.') != std::string_view::npos;
  return is_fraction ? std::nullopt : number;
}

// Red, green and blue of 255.
bool readColor(std::string_view& rest, Vec3d& rgb) {
  for (int c = 0; c < 3; ++c) {
    const std::optional<double> part = nextByte(rest);
    if (!part) return false;
    rgb[c] = *part / 255;
  }
  return true;
}

std::string_view unquoted(std::string_view text) {
  text = trimmed(text);
  const bool is_quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return is_quoted ? text.substr(1, text.size() - 2) : text;
}

// Reads the fields behind the number in a line of ITK-SNAP.
bool readSnap(std::string_view rest, LabelStyle& style) {
  if (!readColor(rest, style.rgb)) return false;
  const auto opacity = nextNumber(rest, 1), is_visible = nextNumber(rest, 1);
  if (!opacity || !is_visible || !nextNumber(rest, 1)) return false;
  // ITK-SNAP keeps the opacity of hidden labels: visibility is a number of its own.
  style.opacity = *is_visible > 0 ? *opacity : 0;
  style.name = unquoted(rest);
  return true;
}
// The same of 3D Slicer's. Names have no blanks there but those written as underscores.
bool readSlicer(std::string_view rest, LabelStyle& style) {
  style.name = nextWord(rest);
  std::ranges::replace(style.name, '_', ' ');
  if (style.name.empty() || !readColor(rest, style.rgb)) return false;
  const auto opacity = nextByte(rest);
  if (!opacity || !trimmed(rest).empty()) return false;
  style.opacity = *opacity / 255;
  return true;
}

std::optional<LabelStyle> readLine(std::string_view line) {
  LabelStyle style;
  const auto number = numberOf(nextWord(line));
  // Numbers beyond are no voxel's, or are not told apart.
  constexpr double kMostLabel = 9007199254740992;  // 2^53
  if (!number || *number != std::floor(*number) || std::abs(*number) > kMostLabel)
    return std::nullopt;
  style.label = *number;
  std::string_view ahead = line;
  // 3D Slicer has a name in second place, ITK-SNAP the red of the colour.
  const bool is_snap = numberOf(nextWord(ahead)).has_value();
  return (is_snap ? readSnap(line, style) : readSlicer(line, style)) ? std::optional(style)
                                                                     : std::nullopt;
}

}  // namespace

std::vector<LabelStyle> readLabelTable(const std::filesystem::path& path, const StopToken& stop) {
  return parseLabelTable(readTextFile(path, kMostTableBytes, "a table of labels", stop),
                         path.string());
}

std::vector<LabelStyle> parseLabelTable(std::string_view text, const std::string& where) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::vector<LabelStyle> table;
  int number = 0;
  for (size_t from = 0; from < text.size();) {
    const size_t end = std::min(text.find('\n', from), text.size());
    const std::string_view line = trimmed(text.substr(from, end - from));
    from = end + 1;
    ++number;
    if (line.empty() || line.front() == '#') continue;
    const std::optional<LabelStyle> style = readLine(line);
    if (!style)
      fail("{}: line {}: expected {}, found {}", where, number, kExpectedLine, printable(line));
    table.push_back(*style);
    if (table.size() > kMostLabels)
      fail("{}: line {}: more than {} labels", where, number, kMostLabels);
  }
  if (table.empty()) fail("{}: expected {} in a line, found none", where, kExpectedLine);
  // FreeSurfer's table has an opacity of 0 for all labels.
  if (std::ranges::all_of(table, [](const LabelStyle& style) { return style.opacity == 0; }))
    for (LabelStyle& style : table) style.opacity = style.label == 0 ? 0 : 1;
  // They are sorted by label, so that applyTable() can look them up.
  std::ranges::stable_sort(table, {}, &LabelStyle::label);
  for (size_t i = 1; i < table.size(); ++i)
    if (table[i].label == table[i - 1].label)
      fail("{}: label {} is there twice; remove one of its lines", where, table[i].label);
  return table;
}

std::vector<LabelStyle> labelStyles(const std::vector<double>& values, double background,
                                    std::string_view map) {
  SLUICE_CHECK(!values.empty());
  TransferFunction over_values;
  if (!map.empty())
    over_values.colors = rescale(requireColorMap(map, "--map"), values.front(), values.back());
  std::vector<LabelStyle> styles;
  styles.reserve(values.size());
  for (const double value : values)
    styles.push_back({value, map.empty() ? labelColor(value) : colorAt(over_values, value),
                      value == background ? 0.0 : 1.0, std::string(), value == background});
  return styles;
}

std::string faultOfTable(const std::vector<LabelStyle>& table,
                         const std::vector<LabelStyle>& styles, const ValueCounts& counts) {
  // Nothing is known of a volume that was not read.
  if (counts.entries.empty()) return {};
  const auto shows = [](const LabelStyle& style) { return style.opacity > 0; };
  const auto showsVoxels = [&](const LabelStyle& style) {
    return shows(style) && std::ranges::any_of(counts.entries, [&](const ValueCount& entry) {
             return entry.lo <= style.label && style.label <= entry.hi;
           });
  };
  if (std::ranges::none_of(table, shows) || std::ranges::any_of(table, showsVoxels)) return {};
  constexpr size_t kMostListed = 8;
  std::vector<std::string> labels;
  for (const LabelStyle& style : styles) {
    if (style.is_background) continue;
    labels.push_back(labels.size() < kMostListed ? fmt::format("{:.17g}", style.label) : "...");
    if (labels.size() > kMostListed) break;
  }
  return fmt::format(
      "no label that it shows is in the volume, which has {}; give the table of this volume, or "
      "leave it out for usual colours",
      labels.empty() ? "none" : fmt::format("{}", fmt::join(labels, ", ")));
}

void applyTable(std::vector<LabelStyle>& styles, const std::vector<LabelStyle>& table) {
  for (LabelStyle& style : styles) {
    const auto found = std::ranges::lower_bound(table, style.label, {}, &LabelStyle::label);
    const bool is_background = style.is_background;
    if (found != table.end() && found->label == style.label)
      style = *found;
    else
      // A label that the table does not have is hidden.
      style.opacity = 0;
    // The background is the volume's, whatever the table calls it.
    style.is_background = is_background;
  }
}

void scaleOpacities(std::vector<LabelStyle>& styles, double factor) {
  for (LabelStyle& style : styles) style.opacity *= factor;
}

void applyLooks(std::vector<LabelStyle>& styles, const std::vector<LabelLook>& looks) {
  for (const LabelLook& look : looks) {
    std::optional<Vec3d> rgb;
    if (!look.color.empty()) {
      rgb = solidColor(look.color);
      if (!rgb)
        failRequest("--label {}: there is no colour {}; give RRGGBB or one of {}",
                    labelLookText(look), look.color, fmt::join(solidColorNames(), ", "));
    }
    for (LabelStyle& style : styles) {
      if (style.label < look.first || style.label > look.last) continue;
      // A look for all labels leaves the background as it is.
      if (style.is_background && std::isinf(look.first) && std::isinf(look.last)) continue;
      if (rgb) style.rgb = *rgb;
      if (look.opacity) style.opacity = *look.opacity;
    }
  }
}

size_t labelsTooClose(const std::vector<LabelStyle>& styles) {
  if (styles.empty()) return 0;
  const double span = styles.back().label - styles.front().label;
  if (span < kMostLabelEntries) return 0;
  const double entry = span / (kMostLabelEntries - 1);
  const auto isClose = [&](size_t i) {
    return i > 0 && i < styles.size() && styles[i].label - styles[i - 1].label <= entry;
  };
  size_t count = 0;
  for (size_t i = 0; i < styles.size(); ++i)
    if (isClose(i) || isClose(i + 1)) ++count;
  return count;
}

TransferFunction labelsTransfer(const std::vector<LabelStyle>& styles) {
  SLUICE_CHECK(!styles.empty());
  TransferFunction transfer;
  transfer.labels = true;
  transfer.name = fmt::format("{} labels", styles.size() - 1);
  for (size_t i = 0; i < styles.size(); ++i) {
    const double value = styles[i].label;
    // Half way to its neighbours, so that rounding moves no label into the next one's colour.
    const double lo = i == 0 ? value : std::midpoint(styles[i - 1].label, value);
    const double hi = i + 1 == styles.size() ? value : std::midpoint(value, styles[i + 1].label);
    for (const double end : {lo, hi}) {
      transfer.colors.push_back({end, styles[i].rgb});
      transfer.opacities.push_back({end, styles[i].opacity});
    }
  }
  return transfer;
}

}  // namespace sluice

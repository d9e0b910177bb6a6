#include "src/classify/transfer/transfer_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>

#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/files/text_file.h"
#include "src/base/looks/color_word.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/paraview_map.h"

namespace sluice {
namespace {

constexpr const char* kVersionField = "sluice_transfer_function";
constexpr int kVersion = 1;
// No transfer function is this long; a volume given by mistake is.
constexpr uint64_t kMostBytes = uint64_t{16} << 20;

// "#rrggbb".
Vec3d colorOf(const JsonField& field) {
  const std::string& text = field.text();
  const std::optional<Vec3d> color = hexColor(text);
  // hexColor() also takes colours without the sign, which the format does not allow.
  if (!color || text[0] != '#') field.failExpected("a colour as '#rrggbb'");
  return *color;
}

// [value, r, g, b] or [value, "#rrggbb"].
ColorPoint colorPoint(const JsonField& field) {
  if (field.isArray() && field.size() == 2) return {field[0].number(), colorOf(field[1])};
  if (!field.isArray() || field.size() != 4)
    field.failExpected("[value, r, g, b] or [value, '#rrggbb']");
  return {field[0].number(), {field[1].share(), field[2].share(), field[3].share()}};
}

OpacityPoint opacityPoint(const JsonField& field) {
  if (!field.isArray() || field.size() != 2) field.failExpected("[value, opacity]");
  return {field[0].number(), field[1].share()};
}

// The opacity of one voxel length: its transmittance is the unit_length_vox-th root of that of
// unit_length_vox.
double ofOneVoxel(double opacity, double unit_length_vox) {
  return -std::expm1(std::log1p(-opacity) / unit_length_vox);
}

// Appends the opacities of one voxel length on the way from a point of those of unit_length_vox to
// the next, in as many straight pieces as follow the curve.
void appendCurve(const OpacityPoint& from, const OpacityPoint& to, double unit_length_vox,
                 int halvings, std::vector<OpacityPoint>& out) {
  constexpr double kTolerance = 1e-3;
  const double first = ofOneVoxel(from.opacity, unit_length_vox),
               last = ofOneVoxel(to.opacity, unit_length_vox);
  double most_off = 0;
  for (const double part : {0.25, 0.5, 0.75}) {
    const double opacity = ofOneVoxel(std::lerp(from.opacity, to.opacity, part), unit_length_vox);
    // Off by more than a thousandth at a quarter, the middle or three quarters: two pieces follow
    // better.
    most_off = std::max(most_off, std::abs(opacity - std::lerp(first, last, part)));
  }
  if (halvings > 0 && to.value > from.value && most_off > kTolerance) {
    const OpacityPoint middle{std::midpoint(from.value, to.value),
                              std::midpoint(from.opacity, to.opacity)};
    appendCurve(from, middle, unit_length_vox, halvings - 1, out);
    appendCurve(middle, to, unit_length_vox, halvings - 1, out);
    return;
  }
  out.push_back({to.value, last});
}

std::vector<OpacityPoint> curveOf(const std::vector<OpacityPoint>& given, double unit_length_vox) {
  if (unit_length_vox == 1) return given;
  // Opacities that were linear between the converted points were off by up to 0.155.
  constexpr int kMostHalvings = 16;
  std::vector<OpacityPoint> curve{
      {given.front().value, ofOneVoxel(given.front().opacity, unit_length_vox)}};
  for (size_t i = 1; i < given.size(); ++i)
    appendCurve(given[i - 1], given[i], unit_length_vox, kMostHalvings, curve);
  return curve;
}

// The points of a list, ascending.
template <class Point, class Read>
std::vector<Point> points(const JsonField& list, const Read& read) {
  if (list.size() == 0) list.failExpected("at least one point");
  std::vector<Point> result;
  for (size_t i = 0; i < list.size(); ++i) {
    const Point point = read(list[i]);
    if (i > 0 && point.value < result.back().value) {
      list[i][0].failExpected(fmt::format("{} or more, as points ascend", result.back().value));
    }
    result.push_back(point);
  }
  return result;
}

// [magnitude, factor] or [magnitude, [[value, factor], ...]].
GradientRow gradientRow(const JsonField& field) {
  if (!field.isArray() || field.size() != 2)
    field.failExpected("[magnitude, factor] or [magnitude, [[value, factor], ...]]");
  GradientRow row{field[0].number(), {}};
  if (row.magnitude < 0) field[0].failExpected("a magnitude of 0 or more");
  row.factors = field[1].isArray() ? points<OpacityPoint>(
                                         field[1],
                                         [](const JsonField& point) {
                                           if (!point.isArray() || point.size() != 2)
                                             point.failExpected("[value, factor]");
                                           return OpacityPoint{point[0].number(), point[1].share()};
                                         })
                                   : std::vector<OpacityPoint>{{0, field[1].share()}};
  return row;
}

std::vector<GradientRow> readGradients(const JsonField& document) {
  std::vector<GradientRow> rows;
  const auto list = document.find("gradient_opacities");
  if (!list) return rows;
  if (list->size() == 0 || list->size() > kMostGradientRows)
    list->failExpected(fmt::format("1 to {} gradient magnitudes", kMostGradientRows));
  for (size_t i = 0; i < list->size(); ++i) {
    rows.push_back(gradientRow((*list)[i]));
    if (i > 0 && rows[i].magnitude <= rows[i - 1].magnitude)
      (*list)[i][0].failExpected(
          fmt::format("more than {}, as magnitudes ascend", rows[i - 1].magnitude));
  }
  return rows;
}

// true: values are fractions of the volume's range.
bool readDomain(const JsonField& document) {
  const auto domain = document.find("domain");
  if (!domain) return false;
  if (domain->text() != "unit" && domain->text() != "values")
    domain->failExpected("'values' or 'unit'");
  return domain->text() == "unit";
}

double readUnitLength(const JsonField& document) {
  const auto field = document.find("unit_length_vox");
  if (!field) return 1;
  if (!(field->number() > 0)) field->failExpected("a length above 0");
  return field->number();
}

std::vector<ColorPoint> readColors(const JsonField& document, ValueRange whole,
                                   const std::string& where) {
  const auto map = document.find("map"), colors = document.find("colors"),
             map_range = document.find("map_range");
  // One of both: a file with both would leave open which one counts.
  if (map.has_value() == colors.has_value()) {
    fail("{}: expected one of the fields /map and /colors, found {}", where, map ? "both" : "none");
  }
  if (colors) {
    if (map_range) map_range->failExpected("no map_range without a map");
    return points<ColorPoint>(*colors, colorPoint);
  }
  if (map_range) {
    if (map_range->size() != 2) map_range->failExpected("[lo, hi]");
    whole = {(*map_range)[0].number(), (*map_range)[1].number()};
    if (whole.hi < whole.lo) map_range->failExpected("[lo, hi] with lo <= hi");
  }
  return rescale(requireColorMap(map->text(), fmt::format("{}: /map", where)), whole.lo, whole.hi);
}

TransferFunction ownTransfer(const JsonField& document, const std::string& where,
                             ValueRange range) {
  document.allowOnly({kVersionField, "name", "comment", "domain", "map", "map_range", "colors",
                      "opacities", "gradient_opacities", "labels", "unit_length_vox"});
  const JsonField version = document.require(kVersionField);
  if (version.number() != kVersion) version.failExpected(fmt::format("version {}", kVersion));
  const bool unit = readDomain(document);
  const double unit_length_vox = readUnitLength(document);
  TransferFunction transfer;
  const auto name = document.find("name");
  transfer.name = name ? name->text() : where;
  transfer.colors = readColors(document, unit ? ValueRange{0, 1} : range, where);
  transfer.opacities =
      curveOf(points<OpacityPoint>(document.require("opacities"), opacityPoint), unit_length_vox);
  transfer.gradients = readGradients(document);
  if (const auto labels = document.find("labels")) transfer.labels = labels->flag();
  // Magnitudes scale with the range, values move with it, too.
  if (unit) {
    for (GradientRow& row : transfer.gradients) {
      row.magnitude *= range.hi - range.lo;
      for (OpacityPoint& point : row.factors)
        point.value = std::lerp(range.lo, range.hi, point.value);
    }
    for (ColorPoint& point : transfer.colors)
      point.value = std::lerp(range.lo, range.hi, point.value);
    for (OpacityPoint& point : transfer.opacities)
      point.value = std::lerp(range.lo, range.hi, point.value);
  }
  return transfer;
}

}  // namespace

TransferFunction parseTransferFunction(std::string_view json, const std::string& where,
                                       ValueRange range, std::string_view map) {
  const nlohmann::json parsed = parseJson(json, where);
  const JsonField document(parsed, where);
  const bool paraview = document.isArray() || (document.isObject() && document.find("RGBPoints"));
  TransferFunction transfer = paraview ? paraviewTransfer(document, where, range, map)
                                       : ownTransfer(document, where, range);
  // The map stretches over the values that the file's colours have.
  if (!paraview && !map.empty())
    transfer.colors = rescale(requireColorMap(map, "--map"), transfer.colors.front().value,
                              transfer.colors.back().value);
  validate(transfer, where);
  return transfer;
}

TransferFunction readTransferFunction(const std::filesystem::path& path, ValueRange range,
                                      std::string_view map, const StopToken& stop) {
  return parseTransferFunction(readTextFile(path, kMostBytes, "a transfer function", stop),
                               path.string(), range, map);
}

std::string writeTransferFunction(const TransferFunction& transfer) {
  nlohmann::ordered_json json;
  json[kVersionField] = kVersion;
  json["name"] = transfer.name;
  json["domain"] = "values";
  auto& colors = json["colors"] = nlohmann::ordered_json::array();
  for (const auto& [value, rgb] : transfer.colors) {
    colors.push_back({value, rgb.x, rgb.y, rgb.z});
  }
  auto& opacities = json["opacities"] = nlohmann::ordered_json::array();
  for (const auto& [value, opacity] : transfer.opacities) opacities.push_back({value, opacity});
  if (transfer.labels) json["labels"] = true;
  if (!transfer.gradients.empty()) {
    auto& gradients = json["gradient_opacities"] = nlohmann::ordered_json::array();
    for (const auto& [magnitude, factors] : transfer.gradients) {
      auto list = nlohmann::ordered_json::array();
      for (const auto& [value, factor] : factors) list.push_back({value, factor});
      gradients.push_back({magnitude, list});
    }
  }
  // A name made from a path may be no UTF-8.
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace sluice

#include "src/classify/transfer/paraview_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/classify/transfer/color_spaces.h"
#include "src/classify/transfer/transfer_makers.h"

namespace sluice {
namespace {

constexpr double kColorTolerance = 0.5 / 255;
constexpr double kOpacityTolerance = 0.001;
// 2^kDeepest parts of a segment are enough for any curve here.
constexpr int kDeepest = 10;
// More than any preset has; bounds the points that a hostile file makes us insert.
constexpr size_t kMostPoints = 4096;
// VTK draws a line below the first and a step above the second.
constexpr double kLine = 0.01, kStep = 0.99;

using Mix = Vec3d (*)(Vec3d, Vec3d, double);

struct ColorSpace {
  std::string_view name;
  Mix mix;  // null: steps
};

Vec3d mixRgb(Vec3d a, Vec3d b, double t) {
  return {std::lerp(a.x, b.x, t), std::lerp(a.y, b.y, t), std::lerp(a.z, b.z, t)};
}

constexpr std::array<ColorSpace, 7> kColorSpaces = {{{"RGB", mixRgb},
                                                     {"HSV", mixHsv},
                                                     {"HSVNoWrap", mixHsv},
                                                     {"Lab", mixLab},
                                                     {"CIELAB", mixLab},
                                                     {"Diverging", mixDiverging},
                                                     {"Step", nullptr}}};

// Calls add(t, curve(t)) for places between `lo` and `hi` until lines between neighbours follow the
// curve. `apart(a, b)` tells whether two results differ too much; `between` mixes two linearly.
template <class Result, class Curve, class Apart, class Between, class Add>
void follow(const Curve& curve, double lo, Result at_lo, double hi, Result at_hi, int depth,
            const Apart& apart, const Between& between, const Add& add) {
  if (depth == kDeepest) return;
  bool straight = true;
  // Three places, because a curve may cross its line in the middle.
  for (const double part : {0.25, 0.5, 0.75}) {
    const double t = std::lerp(lo, hi, part);
    straight = straight && !apart(curve(t), between(at_lo, at_hi, part));
  }
  if (straight) return;
  const double t = std::midpoint(lo, hi);
  const Result at_t = curve(t);
  follow(curve, lo, at_lo, t, at_t, depth + 1, apart, between, add);
  add(t, at_t);
  follow(curve, t, at_t, hi, at_hi, depth + 1, apart, between, add);
}

void appendColors(std::vector<ColorPoint>& points, const ColorPoint& next, Mix mix) {
  const ColorPoint from = points.back();
  if (mix == nullptr) {
    // An interval has the colour of its end.
    points.push_back({from.value, next.rgb});
  } else if (mix != mixRgb) {
    follow<Vec3d>(
        [&](double t) { return mix(from.rgb, next.rgb, t); }, 0, from.rgb, 1, next.rgb, 0,
        [](Vec3d a, Vec3d b) {
          const Vec3d d = a - b;
          return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) > kColorTolerance;
        },
        mixRgb,
        [&](double t, Vec3d rgb) {
          points.push_back({std::lerp(from.value, next.value, t), rgb});
        });
  }
  points.push_back(next);
}

// VTK keeps the midpoint off the ends.
double tame(double midpoint) {
  return std::clamp(midpoint, 1e-5, 1 - 1e-5);
}

void appendOpacities(std::vector<OpacityPoint>& points, const OpacityPoint& next, double midpoint,
                     double sharpness) {
  const OpacityPoint from = points.back();
  const auto add = [&](double t, double way) {
    points.push_back({std::lerp(from.value, next.value, t),
                      std::clamp(std::lerp(from.opacity, next.opacity, way), 0.0, 1.0)});
  };
  const double middle = tame(midpoint);
  if (sharpness > kStep) {
    add(middle, 0);
    add(middle, 1);
  } else if (sharpness < kLine) {
    if (midpoint != 0.5) add(middle, 0.5);
  } else {
    const auto curve = [&](double t) { return bentWay(t, midpoint, sharpness); };
    const auto apart = [](double a, double b) { return std::abs(a - b) > kOpacityTolerance; };
    const auto line = [](double a, double b, double t) { return std::lerp(a, b, t); };
    // The curve has a corner at its middle.
    follow<double>(curve, 0, 0, middle, 0.5, 0, apart, line, add);
    add(middle, 0.5);
    follow<double>(curve, middle, 0.5, 1, 1, 0, apart, line, add);
  }
  points.push_back(next);
}

// Checks that a flat list holds points of four numbers, ascending; calls use(i, value).
template <class Use>
void forEachPoint(const JsonField& list, const char* expected, const Use& use) {
  const size_t size = list.size();
  // The list is flat, as VTK writes it.
  if (size == 0 || size % 4 != 0) list.failExpected(expected);
  if (size > 4 * kMostPoints) list.failExpected(fmt::format("at most {} points", kMostPoints));
  for (size_t i = 0; i < size; i += 4) {
    const double value = list[i].number();
    if (i > 0 && value < list[i - 4].number()) {
      list[i].failExpected(fmt::format("{} or more, as points ascend", list[i - 4].number()));
    }
    use(i, value);
  }
}

std::vector<ColorPoint> readColors(const JsonField& list, Mix mix) {
  std::vector<ColorPoint> points;
  forEachPoint(list, "x, r, g, b for each point", [&](size_t i, double value) {
    const ColorPoint point{value, {list[i + 1].share(), list[i + 2].share(), list[i + 3].share()}};
    points.empty() ? points.push_back(point) : appendColors(points, point, mix);
  });
  return points;
}

std::vector<OpacityPoint> readOpacities(const JsonField& list) {
  std::vector<OpacityPoint> points;
  double midpoint = 0.5, sharpness = 0;  // for the segment that the next point ends
  forEachPoint(list, "x, opacity, midpoint, sharpness for each point", [&](size_t i, double value) {
    const OpacityPoint point{value, list[i + 1].share()};
    points.empty() ? points.push_back(point) : appendOpacities(points, point, midpoint, sharpness);
    midpoint = list[i + 2].share();
    sharpness = list[i + 3].share();
  });
  return points;
}

// How colours are mixed between points; null: not at all, in steps.
Mix readSpace(const JsonField& map) {
  const auto field = map.find("ColorSpace");
  if (!field) return mixRgb;
  for (const ColorSpace& space : kColorSpaces) {
    if (space.name != field->text()) continue;
    // ParaView names the space HSV for both ways round, and tells by HSVWrap.
    const auto wrap = map.find("HSVWrap");
    return space.name == "HSV" && wrap && wrap->flag() ? mixHsvShortWay : space.mix;
  }
  field->failExpected("RGB, HSV, Lab, Diverging or Step");
}

std::string nameOf(const JsonField& map) {
  const auto name = map.find("Name");
  return name ? name->text() : std::string();
}

JsonField choose(const JsonField& document, std::string_view wanted) {
  std::vector<JsonField> maps;
  if (document.isObject()) maps.push_back(document);
  for (size_t i = 0; document.isArray() && i < document.size(); ++i) maps.push_back(document[i]);
  std::vector<std::string> names;
  for (const JsonField& map : maps) {
    names.push_back(nameOf(map));
    if (!wanted.empty() && names.back() == wanted) return map;
  }
  // A map of one of our names recolours the only map of a file.
  if (maps.size() == 1 && (wanted.empty() || colorMap(wanted))) return maps.front();
  if (names.empty()) document.failExpected("at least one colour map");
  const std::string listed = printable(fmt::format("{}", fmt::join(names, ", ")), 400);
  document.failExpected(wanted.empty()
                            ? fmt::format("one colour map, or --map with one of {}", listed)
                            : fmt::format("a colour map named '{}' among {}", wanted, listed));
}

template <class Point>
void stretch(std::vector<Point>& points, ValueRange range) {
  const double lo = points.front().value, hi = points.back().value;
  for (Point& point : points) {
    // Halves, because the width of the range may overflow.
    const double t = hi > lo ? (point.value / 2 - lo / 2) / (hi / 2 - lo / 2) : 0;
    point.value = std::lerp(range.lo, range.hi, t);
  }
}

// ParaView's presets lie at 0 to 1 or -1 to 1. These, and maps that lie beside the data, are
// stretched over it.
bool isPreset(double lo, double hi, ValueRange range) {
  return (lo == 0 && hi == 1) || (lo == -1 && hi == 1) || hi < range.lo || lo > range.hi;
}

}  // namespace

double bentWay(double t, double midpoint, double sharpness) {
  const double middle = tame(midpoint);
  double s = t < middle ? 0.5 * t / middle : 0.5 + 0.5 * (t - middle) / (1 - middle);
  if (sharpness > kStep) return s < 0.5 ? 0 : 1;
  if (sharpness < kLine) return s;
  // Each half is bent by a power, then both pass a cubic that starts and ends with the slope that
  // is left at this sharpness.
  const double power = 1 + 10 * sharpness;
  s = s < 0.5 ? 0.5 * std::pow(2 * s, power) : 1 - 0.5 * std::pow(2 * (1 - s), power);
  const double slope = 1 - sharpness;
  const double cubic = s * s * (3 - 2 * s) + slope * s * (1 - s) * (1 - 2 * s);
  return std::clamp(cubic, 0.0, 1.0);
}

TransferFunction paraviewTransfer(const JsonField& document, const std::string& where,
                                  ValueRange range, std::string_view wanted) {
  const JsonField map = choose(document, wanted);
  if (const auto log = map.find("UseLogScale"); log && log->flag()) {
    log->failExpected("false: a logarithmic scale is not supported");
  }
  TransferFunction transfer;
  transfer.name = nameOf(map);
  if (transfer.name.empty()) transfer.name = where;
  transfer.colors = readColors(map.require("RGBPoints"), readSpace(map));
  const auto points = map.find("Points");
  transfer.opacities =
      points ? readOpacities(*points)
             : std::vector<OpacityPoint>{{transfer.colors.front().value, 0},
                                         {transfer.colors.back().value, kDefaultOpacity}};
  if (isPreset(transfer.colors.front().value, transfer.colors.back().value, range)) {
    stretch(transfer.colors, range);
    stretch(transfer.opacities, range);
  }
  // The map is one of ours, and not a map of the file.
  if (!wanted.empty() && nameOf(map) != wanted)
    transfer.colors = rescale(requireColorMap(wanted, "--map"), transfer.colors.front().value,
                              transfer.colors.back().value);
  return transfer;
}

}  // namespace sluice

#include "src/classify/transfer/color_spaces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sluice {
namespace {

using std::numbers::pi;

// The white of D65 in XYZ.
constexpr Vec3d kWhite{0.9505, 1.0, 1.089};

Vec3d each(Vec3d v, double (*f)(double)) {
  return {f(v.x), f(v.y), f(v.z)};
}

double linearFromScreen(double c) {
  return c > 0.04045 ? std::pow((c + 0.055) / 1.055, 2.4) : c / 12.92;
}

double screenFromLinear(double c) {
  return c > 0.0031308 ? 1.055 * std::pow(c, 1 / 2.4) - 0.055 : 12.92 * c;
}

// CIELAB's cube root with a straight foot, and its inverse.
double compress(double t) {
  return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116;
}

double expand(double t) {
  return t * t * t > 0.008856 ? t * t * t : (t - 16.0 / 116) / 7.787;
}

Vec3d mix(Vec3d a, Vec3d b, double t) {
  return {std::lerp(a.x, b.x, t), std::lerp(a.y, b.y, t), std::lerp(a.z, b.z, t)};
}

// Moreland's polar CIELAB: magnitude, saturation (the angle to the grey axis), hue.
struct Msh {
  double m = 0, s = 0, h = 0;
};

Msh mshFromRgb(Vec3d rgb) {
  const Vec3d lab = labFromRgb(rgb);
  const double m = length(lab);
  // Black has no angles.
  const double s = m > 0.001 ? std::acos(std::clamp(lab.x / m, -1.0, 1.0)) : 0;
  return {m, s, s > 0.001 ? std::atan2(lab.z, lab.y) : 0};
}

Vec3d rgbFromMsh(Msh c) {
  return rgbFromLab({c.m * std::cos(c.s), c.m * std::sin(c.s) * std::cos(c.h),
                     c.m * std::sin(c.s) * std::sin(c.h)});
}

double angleBetween(double a, double b) {
  const double difference = std::abs(a - b);
  return difference > pi ? std::abs(2 * pi - difference) : difference;
}

// The hue that a grey of magnitude `grey_m` gets opposite a saturated colour: turned so that the
// way between them is even.
double hueOfGrey(Msh saturated, double grey_m) {
  // A grey that is no brighter than the colour needs no turn.
  if (saturated.m >= grey_m - 0.1) return saturated.h;
  const double spin = saturated.s * std::sqrt(grey_m * grey_m - saturated.m * saturated.m) /
                      (saturated.m * std::sin(saturated.s));
  // The paper turns at -pi / 3 so as to keep clear of purple; ParaView's limit lies a little
  // higher.
  return saturated.h > -0.3 * pi ? saturated.h + spin : saturated.h - spin;
}

}  // namespace

Vec3d labFromRgb(Vec3d rgb) {
  const Vec3d linear = each(rgb, linearFromScreen);
  const Vec3d xyz{dot(linear, {0.4124, 0.3576, 0.1805}), dot(linear, {0.2126, 0.7152, 0.0722}),
                  dot(linear, {0.0193, 0.1192, 0.9505})};
  const Vec3d f = each(xyz / kWhite, compress);
  return {116 * f.y - 16, 500 * (f.x - f.y), 200 * (f.y - f.z)};
}

Vec3d rgbFromLab(Vec3d lab) {
  const double y = (lab.x + 16) / 116;
  const Vec3d xyz = each({y + lab.y / 500, y, y - lab.z / 200}, expand) * kWhite;
  const Vec3d linear{dot(xyz, {3.2406, -1.5372, -0.4986}), dot(xyz, {-0.9689, 1.8758, 0.0415}),
                     dot(xyz, {0.0557, -0.2040, 1.0570})};
  Vec3d rgb = each(linear, screenFromLinear);
  // Colours out of range are scaled, not cut, which keeps their hue.
  rgb = rgb / std::max({1.0, rgb.x, rgb.y, rgb.z});
  return max(rgb, Vec3d{0, 0, 0});
}

Vec3d hsvFromRgb(Vec3d rgb) {
  const double most = std::max({rgb.x, rgb.y, rgb.z}), least = std::min({rgb.x, rgb.y, rgb.z});
  const double chroma = most - least;
  if (chroma <= 0) return {0, 0, most};
  double sixths = 0;
  if (most == rgb.x) {
    sixths = (rgb.y - rgb.z) / chroma;
  } else if (most == rgb.y) {
    sixths = 2 + (rgb.z - rgb.x) / chroma;
  } else {
    sixths = 4 + (rgb.x - rgb.y) / chroma;
  }
  return {(sixths < 0 ? sixths + 6 : sixths) / 6, chroma / most, most};
}

Vec3d rgbFromHsv(Vec3d hsv) {
  // Each channel is a trapezoid over the hue, a third of the circle after the one before.
  const auto channel = [&](double shift) {
    const double place = std::fmod(shift + 6 * hsv.x, 6);
    return hsv.z * (1 - hsv.y * std::clamp(std::min(place, 4 - place), 0.0, 1.0));
  };
  return {channel(5), channel(3), channel(1)};
}

Vec3d mixLab(Vec3d a, Vec3d b, double t) {
  return rgbFromLab(mix(labFromRgb(a), labFromRgb(b), t));
}

Vec3d mixHsv(Vec3d a, Vec3d b, double t) {
  return rgbFromHsv(mix(hsvFromRgb(a), hsvFromRgb(b), t));
}

Vec3d mixHsvShortWay(Vec3d a, Vec3d b, double t) {
  Vec3d p = hsvFromRgb(a), q = hsvFromRgb(b);
  // The shorter way round passes 0, where the hue goes on at 1.
  if (p.x - q.x > 0.5) q.x += 1;
  if (q.x - p.x > 0.5) p.x += 1;
  Vec3d mixed = mix(p, q, t);
  if (mixed.x >= 1) mixed.x -= 1;
  return rgbFromHsv(mixed);
}

Vec3d mixDiverging(Vec3d a, Vec3d b, double t) {
  constexpr double kSaturated = 0.05;
  Msh p = mshFromRgb(a), q = mshFromRgb(b);
  // Moreland 2009: two saturated colours of different hue meet in a white that is at least as
  // bright as both.
  if (p.s > kSaturated && q.s > kSaturated && angleBetween(p.h, q.h) > 0.33 * pi) {
    const Msh white{std::max({p.m, q.m, 88.0}), 0, 0};
    (t < 0.5 ? q : p) = white;
    t = t < 0.5 ? 2 * t : 2 * t - 1;
  }
  if (p.s < kSaturated && q.s > kSaturated) p.h = hueOfGrey(q, p.m);
  if (q.s < kSaturated && p.s > kSaturated) q.h = hueOfGrey(p, q.m);
  return rgbFromMsh({std::lerp(p.m, q.m, t), std::lerp(p.s, q.s, t), std::lerp(p.h, q.h, t)});
}

}  // namespace sluice

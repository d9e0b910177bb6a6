#include "src/classify/transfer/color_maps.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "src/base/error.h"
#include "src/base/looks/color_word.h"
#include "src/classify/transfer/color_spaces.h"

namespace sluice {
namespace {

// Control points at positions 0..255, the entries of the published tables. The points of viridis,
// inferno, plasma, magma, cividis and turbo are fitted to the tables by least squares, as few as
// stay within 2/255 of every entry.
constexpr ColorPoint kViridis[] = {{0, {0.267, 0.0049, 0.3294}},    {27, {0.2861, 0.1523, 0.4704}},
                                   {52, {0.2529, 0.2722, 0.5367}},  {94, {0.1736, 0.4429, 0.5621}},
                                   {139, {0.1144, 0.607, 0.5446}},  {156, {0.1384, 0.6699, 0.512}},
                                   {174, {0.228, 0.7324, 0.4622}},  {198, {0.4162, 0.8094, 0.3566}},
                                   {236, {0.8014, 0.8861, 0.1127}}, {245, {0.8976, 0.8926, 0.0905}},
                                   {255, {0.9932, 0.9062, 0.1439}}};
constexpr ColorPoint kInferno[] = {{0, {0.0015, 0.0005, 0.0139}},   {14, {0.0296, 0.0254, 0.1211}},
                                   {32, {0.1272, 0.0516, 0.2924}},  {44, {0.2117, 0.0337, 0.3836}},
                                   {59, {0.3105, 0.0498, 0.4282}},  {84, {0.4659, 0.1091, 0.4334}},
                                   {112, {0.6414, 0.1687, 0.3858}}, {143, {0.8212, 0.2656, 0.2734}},
                                   {170, {0.9345, 0.4082, 0.1453}}, {195, {0.9852, 0.5781, 0.0204}},
                                   {203, {0.9877, 0.6379, 0.0304}}, {217, {0.9853, 0.7434, 0.1345}},
                                   {232, {0.9601, 0.86, 0.2926}},   {245, {0.9429, 0.9514, 0.4899}},
                                   {255, {0.9884, 0.9984, 0.6449}}};
constexpr ColorPoint kPlasma[] = {{0, {0.0504, 0.0298, 0.528}},    {9, {0.1455, 0.0227, 0.5706}},
                                  {38, {0.3398, 0.0046, 0.648}},   {62, {0.483, 0.0022, 0.662}},
                                  {79, {0.5824, 0.063, 0.6406}},   {117, {0.7612, 0.2313, 0.51}},
                                  {163, {0.9146, 0.4371, 0.3486}}, {199, {0.9876, 0.6218, 0.2273}},
                                  {227, {0.9959, 0.7892, 0.1431}}, {253, {0.9478, 0.9612, 0.1506}},
                                  {255, {0.94, 0.9752, 0.1313}}};
constexpr ColorPoint kMagma[] = {{0, {0.0015, 0.0005, 0.0139}},   {17, {0.0397, 0.0357, 0.1386}},
                                 {38, {0.1443, 0.0741, 0.3348}},  {52, {0.2394, 0.0555, 0.4495}},
                                 {68, {0.3418, 0.08, 0.4975}},    {101, {0.543, 0.1605, 0.5111}},
                                 {133, {0.7493, 0.2235, 0.4692}}, {158, {0.8991, 0.3041, 0.3924}},
                                 {177, {0.9667, 0.4235, 0.3534}}, {195, {0.9912, 0.5583, 0.3867}},
                                 {220, {0.9987, 0.7411, 0.5057}}, {255, {0.9871, 0.9914, 0.7495}}};
constexpr ColorPoint kCividis[] = {
    {0, {0, 0.1351, 0.3048}},        {19, {0, 0.187, 0.4355}},
    {23, {0.0041, 0.1957, 0.4427}},  {29, {0.0827, 0.212, 0.4381}},
    {42, {0.1695, 0.2483, 0.4282}},  {74, {0.3048, 0.3343, 0.4191}},
    {136, {0.5169, 0.5074, 0.4753}}, {175, {0.6673, 0.6255, 0.4534}},
    {209, {0.8063, 0.7367, 0.3912}}, {234, {0.914, 0.8252, 0.3087}},
    {252, {0.9958, 0.8923, 0.2045}}, {255, {0.9957, 0.9093, 0.2178}}};
constexpr ColorPoint kTurbo[] = {{0, {0.19, 0.0718, 0.2322}},     {10, {0.2335, 0.1864, 0.5049}},
                                 {20, {0.2619, 0.296, 0.7162}},   {30, {0.2761, 0.4012, 0.8716}},
                                 {40, {0.2771, 0.5013, 0.9705}},  {48, {0.2616, 0.5793, 1}},
                                 {57, {0.2074, 0.6695, 0.9798}},  {70, {0.118, 0.7906, 0.8685}},
                                 {80, {0.0879, 0.867, 0.7607}},   {88, {0.1156, 0.9122, 0.6888}},
                                 {98, {0.2157, 0.9606, 0.5695}},  {116, {0.4899, 1, 0.3337}},
                                 {127, {0.6356, 0.9932, 0.2346}}, {138, {0.7485, 0.9609, 0.1984}},
                                 {157, {0.9189, 0.8385, 0.2241}}, {171, {0.9876, 0.7238, 0.2247}},
                                 {186, {0.9992, 0.566, 0.1602}},  {203, {0.9492, 0.3622, 0.0716}},
                                 {219, {0.8579, 0.218, 0.0239}},  {237, {0.7018, 0.0982, 0.0031}},
                                 {255, {0.4796, 0.0158, 0.0106}}};
// Moreland 2009, diverging in Msh space from (59, 76, 192) to (180, 4, 38).
constexpr ColorPoint kCoolWarm[] = {
    {0, {0.2314, 0.298, 0.7529}},    {27, {0.3581, 0.4796, 0.9016}},
    {52, {0.4893, 0.6298, 0.9821}},  {76, {0.62, 0.7473, 1}},
    {100, {0.7457, 0.8294, 0.9714}}, {126, {0.8623, 0.8701, 0.876}},
    {148, {0.9409, 0.8165, 0.7479}}, {172, {0.9745, 0.7148, 0.6}},
    {197, {0.9534, 0.5694, 0.4461}}, {223, {0.8738, 0.383, 0.2988}},
    {244, {0.7712, 0.1967, 0.1957}}, {252, {0.7238, 0.0909, 0.1616}},
    {255, {0.7059, 0.0158, 0.149}}};
// Moreland's black body: lightness linear in CIELAB through (178, 34, 34), (227, 105, 5), (238,
// 210, 20).
constexpr ColorPoint kBlackBody[] = {{0, {0, 0, 0}},
                                     {6, {0.0755, 0.023, 0.0114}},
                                     {17, {0.1383, 0.0619, 0.0392}},
                                     {48, {0.3283, 0.1047, 0.0832}},
                                     {100, {0.6969, 0.1379, 0.1329}},
                                     {114, {0.7542, 0.2283, 0.1206}},
                                     {137, {0.8432, 0.3515, 0.0771}},
                                     {149, {0.8897, 0.4117, 0.021}},
                                     {167, {0.9119, 0.5338, 0.0248}},
                                     {214, {0.937, 0.8218, 0.0758}},
                                     {215, {0.9353, 0.8255, 0.1071}},
                                     {217, {0.943, 0.8334, 0.1908}},
                                     {222, {0.9629, 0.8547, 0.3316}},
                                     {236, {0.9995, 0.9122, 0.6236}},
                                     {255, {1, 1, 1}}};
constexpr ColorPoint kGrey[] = {{0, {0, 0, 0}}, {255, {1, 1, 1}}};
// Black, red, yellow, white; each channel rises in its own third.
constexpr ColorPoint kHot[] = {
    {0, {0.0416, 0, 0}}, {93, {1, 0, 0}}, {190.5, {1, 1, 0}}, {255, {1, 1, 1}}};
// Dried blood over tan to ivory.
constexpr ColorPoint kCtBone[] = {{0, {0.56, 0.24, 0.13}},   {50, {0.76, 0.4, 0.22}},
                                  {100, {0.87, 0.57, 0.36}}, {150, {0.93, 0.74, 0.55}},
                                  {205, {0.97, 0.89, 0.78}}, {255, {1, 0.98, 0.95}}};
constexpr ColorPoint kCtSoftTissue[] = {{0, {0.28, 0.07, 0.08}},
                                        {70, {0.56, 0.19, 0.17}},
                                        {130, {0.78, 0.41, 0.34}},
                                        {190, {0.91, 0.67, 0.56}},
                                        {255, {0.99, 0.92, 0.85}}};
constexpr ColorPoint kSmoke[] = {{0, {0.2, 0.23, 0.28}},
                                 {90, {0.45, 0.48, 0.53}},
                                 {180, {0.74, 0.76, 0.78}},
                                 {255, {0.98, 0.98, 0.97}}};
// Bright from the start, so that lit surfaces show their shape, and the colour of no material.
constexpr ColorPoint kPlaster[] = {
    {0, {0.5, 0.49, 0.47}}, {128, {0.78, 0.77, 0.75}}, {255, {1, 0.99, 0.97}}};
// Soot over glowing coal to a white-hot flame.
constexpr ColorPoint kEmber[] = {{0, {0.12, 0.1, 0.11}},    {50, {0.3, 0.13, 0.11}},
                                 {110, {0.68, 0.19, 0.06}}, {165, {0.95, 0.46, 0.07}},
                                 {215, {1, 0.78, 0.27}},    {255, {1, 0.97, 0.82}}};

struct NamedMap {
  std::string_view name;
  std::span<const ColorPoint> points;
};

constexpr auto kMaps = std::to_array<NamedMap>({
    {"viridis", kViridis},
    {"inferno", kInferno},
    {"plasma", kPlasma},
    {"magma", kMagma},
    {"cividis", kCividis},
    {"turbo", kTurbo},
    {"cool-warm", kCoolWarm},
    {"black-body", kBlackBody},
    {"hot", kHot},
    {"grey", kGrey},
    {"ct-bone", kCtBone},
    {"ct-soft-tissue", kCtSoftTissue},
    {"smoke", kSmoke},
    {"ember", kEmber},
    {"plaster", kPlaster},
});

constexpr auto kNames = [] {
  std::array<std::string_view, kMaps.size()> names;
  for (size_t i = 0; i < names.size(); ++i) names[i] = kMaps[i].name;
  return names;
}();

// The colours that channels of microscopy are shown in, as displays have them.
constexpr std::array<std::string_view, 8> kColorNames = {"red",     "green",  "blue",   "cyan",
                                                         "magenta", "yellow", "orange", "white"};
constexpr std::array<Vec3d, kColorNames.size()> kColors = {
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}, {1, 1, 0}, {1, 0.5, 0}, {1, 1, 1}}};

}  // namespace

std::span<const std::string_view> colorMapNames() {
  return kNames;
}

std::span<const std::string_view> solidColorNames() {
  return kColorNames;
}

std::optional<Vec3d> solidColor(std::string_view name) {
  for (size_t i = 0; i < kColorNames.size(); ++i)
    if (kColorNames[i] == name) return kColors[i];
  return hexColor(name);
}

std::optional<std::vector<ColorPoint>> colorMap(std::string_view name) {
  const auto found = std::find_if(kMaps.begin(), kMaps.end(),
                                  [&](const NamedMap& map) { return map.name == name; });
  if (found == kMaps.end()) {
    const std::optional<Vec3d> color = solidColor(name);
    if (!color) return std::nullopt;
    // Two points of one colour, since maps are stretched between their ends.
    return std::vector<ColorPoint>{{0, *color}, {1, *color}};
  }
  std::vector<ColorPoint> points(found->points.begin(), found->points.end());
  for (ColorPoint& point : points) point.value /= 255;
  return points;
}

std::vector<ColorPoint> requireColorMap(std::string_view name, const std::string& where) {
  auto points = colorMap(name);
  if (!points) {
    failRequest("{}: expected one of {}, or a colour ({}, #RRGGBB), found '{}'", where,
                fmt::join(kNames, ", "), fmt::join(kColorNames, ", "), name);
  }
  return *std::move(points);
}

Vec3d labelColor(double value) {
  // Turns of the golden angle leave the hues of any few numbers in a row far apart; three steps of
  // lightness tell apart labels that hues alone do not.
  constexpr double kGolden = 0.6180339887498949, kFirstHue = 0.02, kChroma = 58;
  constexpr std::array<double, 3> kLightness = {66, 78, 56};
  const double number = std::abs(std::round(value));
  const double turns = kFirstHue + number * kGolden;
  const double hue = 2 * std::numbers::pi * (turns - std::floor(turns));
  const auto step = static_cast<size_t>(std::fmod(number, 3));
  return rgbFromLab({kLightness[step], kChroma * std::cos(hue), kChroma * std::sin(hue)});
}

std::vector<ColorPoint> rescale(std::vector<ColorPoint> points, double lo, double hi) {
  for (ColorPoint& point : points) point.value = std::lerp(lo, hi, point.value);
  return points;
}

}  // namespace sluice

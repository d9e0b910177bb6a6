// ParaView's colour maps: by rules and by hand here, and against VTK itself if it is installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/classify/transfer/paraview_map.h"
#include "src/classify/transfer/transfer_file.h"
#include "src/classify/transfer/transfer_makers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace sluice::transfer_paraview_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr ValueRange kRange{0, 200};

TransferFunction parsed(const std::string& json, std::string_view map = {}) {
  return parseTransferFunction(json, "p.json", kRange, map);
}

std::string failureOf(const std::string& json, std::string_view map = {}) {
  try {
    parsed(json, map);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// An array of one map with the given fields.
std::string document(const std::string& fields) {
  return R"([{"Name": "test", )" + fields + "}]";
}

TEST(ParaviewMap, readsValuesAsTheyAre) {
  const auto transfer = parsed(document(
      R"("ColorSpace": "RGB", "NanColor": [1, 1, 0], "Creator": "x", "DefaultMap": true,
         "RGBPoints": [40, 0, 0, 1, 160, 1, 0, 0], "Points": [40, 0, 0.5, 0, 100, 0.25, 0.5, 0])"));
  EXPECT_EQ(transfer.name, "test");
  ASSERT_EQ(transfer.colors.size(), 2U);
  EXPECT_EQ(colorAt(transfer, 100), (Vec3d{0.5, 0, 0.5}));
  ASSERT_EQ(transfer.opacities.size(), 2U);
  EXPECT_EQ(opacityAt(transfer, 70), 0.125);
}

TEST(ParaviewMap, stretchesPresetsOverTheRange) {
  const auto ends = [](const std::string& first, const std::string& last) {
    const auto transfer =
        parsed(document(R"("RGBPoints": [)" + first + ", 0, 0, 0, " + last + ", 1, 1, 1]"));
    EXPECT_EQ(transfer.colors.front().value, transfer.opacities.front().value);
    EXPECT_EQ(transfer.colors.back().value, transfer.opacities.back().value);
    return ValueRange{transfer.colors.front().value, transfer.colors.back().value};
  };
  EXPECT_EQ(ends("0", "1"), kRange);
  EXPECT_EQ(ends("-1", "1"), kRange);
  EXPECT_EQ(ends("500", "900"), kRange);
  EXPECT_EQ(ends("-9", "-2"), kRange);
  EXPECT_EQ(ends("0", "2"), (ValueRange{0, 2}));
  EXPECT_EQ(ends("-1000", "3000"), (ValueRange{-1000, 3000}));
}

TEST(ParaviewMap, withoutOpacitiesTheyRise) {
  const auto transfer = parsed(document(R"("RGBPoints": [50, 0, 0, 0, 150, 1, 1, 1])"));
  EXPECT_EQ(opacityAt(transfer, 50), 0);
  EXPECT_EQ(opacityAt(transfer, 150), kDefaultOpacity);
}

TEST(ParaviewMap, stepsTakeTheColorOfTheEndOfAnInterval) {
  const auto transfer = parsed(
      document(R"("ColorSpace": "Step", "RGBPoints": [10, 1, 0, 0, 20, 0, 1, 0, 30, 0, 0, 1])"));
  EXPECT_EQ(colorAt(transfer, 9), (Vec3d{1, 0, 0}));
  EXPECT_EQ(colorAt(transfer, 10.001), (Vec3d{0, 1, 0}));
  EXPECT_EQ(colorAt(transfer, 19.999), (Vec3d{0, 1, 0}));
  EXPECT_EQ(colorAt(transfer, 20.001), (Vec3d{0, 0, 1}));
  EXPECT_EQ(colorAt(transfer, 31), (Vec3d{0, 0, 1}));
}

TEST(ParaviewMap, hueGoesTheLongWayUnlessItWraps) {
  const std::string points = R"("ColorSpace": "HSV", "RGBPoints": [10, 1, 0, 0.2, 20, 1, 0.2, 0])";
  EXPECT_GT(colorAt(parsed(document(points)), 15).z, 0.9);
  const Vec3d wrapped = colorAt(parsed(document(R"("HSVWrap": 1, )" + points)), 15);
  EXPECT_GT(wrapped.x, 0.99);
  EXPECT_LT(wrapped.z, 0.05);
}

TEST(ParaviewMap, midpointWithoutSharpnessIsOneMorePoint) {
  const auto transfer = parsed(document(
      R"("RGBPoints": [0, 0, 0, 0, 100, 1, 1, 1], "Points": [0, 0, 0.25, 0, 100, 1, 0.5, 0])"));
  ASSERT_EQ(transfer.opacities.size(), 3U);
  EXPECT_EQ(opacityAt(transfer, 25), 0.5);
  EXPECT_EQ(opacityAt(transfer, 12.5), 0.25);
  EXPECT_EQ(opacityAt(transfer, 62.5), 0.75);
}

TEST(ParaviewMap, fullSharpnessIsAStepAtTheMidpoint) {
  const auto transfer = parsed(document(
      R"("RGBPoints": [0, 0, 0, 0, 100, 1, 1, 1], "Points": [0, 0.125, 0.25, 1, 100, 1, 0.5, 0])"));
  EXPECT_EQ(opacityAt(transfer, 24.999), 0.125);
  EXPECT_EQ(opacityAt(transfer, 25.001), 1);
}

TEST(ParaviewMap, bentWayKeepsEndsAndMiddleAndRises) {
  for (const double midpoint : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    for (const double sharpness : {0.0, 0.3, 0.7, 0.98}) {
      EXPECT_NEAR(bentWay(0, midpoint, sharpness), 0, 1e-12);
      EXPECT_NEAR(bentWay(1, midpoint, sharpness), 1, 1e-12);
      if (midpoint > 0 && midpoint < 1) {
        EXPECT_NEAR(bentWay(midpoint, midpoint, sharpness), 0.5, 1e-12);
      }
      double before = 0;
      for (int i = 0; i <= 100; ++i) {
        const double now = bentWay(i / 100.0, midpoint, sharpness);
        EXPECT_GE(now, before - 1e-12);
        before = now;
      }
    }
  }
}

TEST(ParaviewMap, isChosenByNameAmongSeveral) {
  const std::string two = R"([{"Name": "a", "RGBPoints": [0, 0, 0, 0]},
                              {"Name": "b", "RGBPoints": [0, 1, 1, 1]}])";
  EXPECT_EQ(parsed(two, "b").colors[0].rgb, (Vec3d{1, 1, 1}));
  EXPECT_THAT(failureOf(two), HasSubstr("--map with one of a, b"));
  EXPECT_THAT(failureOf(two, "c"), HasSubstr("a colour map named 'c' among a, b"));
  EXPECT_EQ(parsed(R"({"Name": "alone", "RGBPoints": [0, 1, 1, 1]})").name, "alone");
  EXPECT_EQ(parsed(R"({"RGBPoints": [0, 1, 1, 1]})").name, "p.json");
}

TEST(ParaviewMap, badInputIsOneLineWithFieldExpectedAndFound) {
  const std::string colors = R"("RGBPoints": [0, 0, 0, 0, 100, 1, 1, 1])";
  const std::pair<std::string, std::string> cases[] = {
      {"[]", "expected at least one colour map at the top"},
      {"[3]", "expected an object at /0, found 3"},
      {"[[]]", "expected an object at /0"},
      {document(R"("ColorSpace": "RGB")"), "expected the field /0/RGBPoints"},
      {document(R"("IndexedColors": [1, 1, 1])"), "expected the field /0/RGBPoints"},
      {document(R"("RGBPoints": [])"), "expected x, r, g, b for each point at /0/RGBPoints"},
      {document(R"("RGBPoints": [0, 1, 1])"), "found an array of 3"},
      {document(R"("RGBPoints": [0, 1, 1, "1"])"), "expected a number at /0/RGBPoints/3"},
      {document(R"("RGBPoints": [0, 1, 1, 255])"), "expected a number in 0..1 at /0/RGBPoints/3"},
      {document(R"("RGBPoints": [1, 0, 0, 0, 0, 1, 1, 1])"),
       "expected 1 or more, as points ascend at /0/RGBPoints/4, found 0"},
      {document(R"("ColorSpace": "Lab/CIEDE2000", )" + colors),
       "expected RGB, HSV, Lab, Diverging or Step at /0/ColorSpace, found 'Lab/CIEDE2000'"},
      {document(R"("ColorSpace": 3, )" + colors), "expected a text at /0/ColorSpace"},
      {document(R"("UseLogScale": true, )" + colors), "at /0/UseLogScale, found true"},
      {document(R"("Points": [0, 0, 0.5], )" + colors), "expected x, opacity, midpoint, sharpness"},
      {document(R"("Points": [0, 2, 0.5, 0], )" + colors), "at /0/Points/1, found 2"},
      {document(R"("Points": [0, 1, 0.5, -1], )" + colors), "at /0/Points/3, found -1"},
      {document(R"("Points": [1, 1, 0.5, 0, 0, 1, 0.5, 0], )" + colors), "at /0/Points/4"},
      {R"([{"Name": 4, )" + colors + "}]", "expected a text at /0/Name"},
  };
  for (const auto& [json, expected] : cases) {
    EXPECT_THAT(failureOf(json),
                AllOf(StartsWith("p.json: "), HasSubstr(expected), Not(HasSubstr("\n"))))
        << json;
  }
}

TEST(ParaviewMap, moreThanAFewThousandPointsAreAnError) {
  std::string points = "0, 0, 0, 0";
  for (int i = 1; i < 5000; ++i) points += ", " + std::to_string(i) + ", 1, 0, 0";
  EXPECT_THAT(failureOf(document(R"("ColorSpace": "Lab", "RGBPoints": [)" + points + "]")),
              HasSubstr("expected at most 4096 points"));
}

// A script for VTK's evaluation of the same points: "r g b opacity" for each value of `samples`.
constexpr const char* kVtkScript = R"(
import json, sys
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction
m = json.load(open(sys.argv[1]))
c = vtkColorTransferFunction()
getattr(c, 'SetColorSpaceTo' + m['ColorSpace'])()
c.SetHSVWrap(m.get('HSVWrap', 0))
p = vtkPiecewiseFunction()
r, o = m['RGBPoints'], m['Points']
for i in range(0, len(r), 4): c.AddRGBPoint(*r[i:i + 4])
for i in range(0, len(o), 4): p.AddPoint(*o[i:i + 4])
for x in m['samples']: print(*c.GetColor(x), p.GetValue(x))
)";

bool haveVtk() {
  return runCommand("/usr/bin/python3 -c 'import vtkmodules.vtkRenderingCore'").status == 0;
}

struct VtkCase {
  std::string space;
  int wrap;
  std::vector<double> colors, opacities;
};

void expectAsVtk(const TempFolder& folder, const VtkCase& test) {
  nlohmann::json map = {{"Name", test.space},
                        {"ColorSpace", test.space},
                        {"HSVWrap", test.wrap},
                        {"RGBPoints", test.colors},
                        {"Points", test.opacities}};
  const auto transfer = parsed(map.dump());
  std::vector<double> samples;
  // Off the points: at a step VTK has the other side.
  for (int i = 0; i < 999; ++i) samples.push_back(0.0371 + i * 0.2);
  map["samples"] = samples;
  writeFile(folder / "map.json", map.dump());
  writeFile(folder / "ask_vtk.py", kVtkScript);
  const auto result =
      runCommand("/usr/bin/python3 " + shellQuoted((folder / "ask_vtk.py").string()) + " " +
                 shellQuoted((folder / "map.json").string()));
  ASSERT_EQ(result.status, 0) << result.output;
  std::istringstream lines(result.output);
  for (const double value : samples) {
    Vec3d rgb;
    double opacity = -1;
    ASSERT_TRUE(lines >> rgb.x >> rgb.y >> rgb.z >> opacity);
    const Vec3d d = colorAt(transfer, value) - rgb;
    EXPECT_LE(std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}), 1.0 / 255)
        << test.space << " at " << value;
    EXPECT_NEAR(opacityAt(transfer, value), opacity, 0.0015) << test.space << " at " << value;
  }
}

TEST(ParaviewMap, followsVtkInEverySpace) {
  if (!haveVtk()) GTEST_SKIP() << "python3-vtk9 is missing";
  const TempFolder folder;
  const std::vector<double> cool_warm = {0, 0.231, 0.298, 0.753, 200, 0.706, 0.016, 0.149};
  // Saturated, grey, black and white neighbours, so that every branch of each space is taken.
  const std::vector<double> many = {0,   0,   0,   0,   20,  1,   0,   0,   50,  0,   1,   0,
                                    70,  0.5, 0.5, 0.5, 90,  0.1, 0.2, 0.9, 120, 1,   1,   0,
                                    150, 1,   1,   1,   170, 0.3, 0,   0.4, 200, 0.9, 0.6, 0.5};
  const std::vector<double> plain = {0, 0, 0.5, 0, 100, 1, 0.5, 0, 200, 0.25, 0.5, 0};
  const std::vector<double> bent = {0,   0,   0.3, 0.2, 40,  1,   0.5, 0.5, 80,  0.1, 0.75, 0.95,
                                    120, 0.9, 0.5, 1,   150, 0.2, 0.2, 0,   200, 0.8, 0.5,  0};
  for (const char* space : {"RGB", "HSV", "Lab", "Diverging", "Step"}) {
    expectAsVtk(folder, {space, 0, many, bent});
    expectAsVtk(folder, {space, 0, cool_warm, plain});
  }
  expectAsVtk(folder, {"HSV", 1, many, plain});
  expectAsVtk(folder, {"HSV", 1, cool_warm, plain});
}

}  // namespace
}  // namespace sluice::transfer_paraview_test

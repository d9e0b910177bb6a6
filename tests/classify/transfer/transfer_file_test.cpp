#include "src/classify/transfer/transfer_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/label_table.h"
#include "src/classify/transfer/transfer_makers.h"
#include "tests/support/gradient_factor.h"
#include "tests/support/temp_folder.h"

namespace sluice::transfer_file_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

constexpr ValueRange kRange{0, 200};

TransferFunction parsed(const std::string& json) {
  return parseTransferFunction(json, "f.json", kRange);
}

// The message of the Error; "" when there is none.
std::string failureOf(const std::string& json) {
  try {
    parsed(json);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// A good file with `fields` in it.
std::string document(const std::string& fields) {
  return R"({"sluice_transfer_function": 1, )" + fields + "}";
}

bool same(const TransferFunction& a, const TransferFunction& b) {
  const auto sameColor = [](const ColorPoint& p, const ColorPoint& q) {
    return p.value == q.value && p.rgb == q.rgb;
  };
  const auto sameOpacity = [](const OpacityPoint& p, const OpacityPoint& q) {
    return p.value == q.value && p.opacity == q.opacity;
  };
  return a.name == b.name &&
         std::equal(a.colors.begin(), a.colors.end(), b.colors.begin(), b.colors.end(),
                    sameColor) &&
         std::equal(a.opacities.begin(), a.opacities.end(), b.opacities.begin(), b.opacities.end(),
                    sameOpacity) &&
         std::equal(a.gradients.begin(), a.gradients.end(), b.gradients.begin(), b.gradients.end(),
                    [&](const GradientRow& p, const GradientRow& q) {
                      return p.magnitude == q.magnitude &&
                             std::equal(p.factors.begin(), p.factors.end(), q.factors.begin(),
                                        q.factors.end(), sameOpacity);
                    });
}

TEST(TransferFile, readsValuesColorsAndOpacities) {
  const auto transfer = parsed(document(R"("name": "bone", "comment": ["any", {"thing": 1}],
      "colors": [[40, 1, 0.5, 0], [100, "#336699"]], "opacities": [[40, 0], [40, 0.01], [200, 0.05]])"));
  EXPECT_EQ(transfer.name, "bone");
  ASSERT_EQ(transfer.colors.size(), 2U);
  EXPECT_EQ(transfer.colors[0].rgb, (Vec3d{1, 0.5, 0}));
  EXPECT_EQ(transfer.colors[1].value, 100);
  EXPECT_NEAR(transfer.colors[1].rgb.x, 0.2, 1e-15);
  EXPECT_NEAR(transfer.colors[1].rgb.y, 0.4, 1e-15);
  EXPECT_NEAR(transfer.colors[1].rgb.z, 0.6, 1e-15);
  EXPECT_EQ(opacityAt(transfer, 39), 0);
  EXPECT_EQ(opacityAt(transfer, 40), 0.01);
  EXPECT_EQ(opacityAt(transfer, 200), 0.05);
}

TEST(TransferFile, laysFractionsOverTheRange) {
  const auto transfer =
      parseTransferFunction(document(R"("domain": "unit", "colors": [[0, 0, 0, 0], [1, 1, 1, 1]],
                  "opacities": [[0.25, 0], [1, 0.5]])"),
                            "f.json", {-100, 300});
  EXPECT_EQ(transfer.colors.front().value, -100);
  EXPECT_EQ(transfer.colors.back().value, 300);
  EXPECT_EQ(transfer.opacities.front().value, 0);
  EXPECT_EQ(transfer.name, "f.json");
}

TEST(TransferFile, stretchesANamedMapOverTheRangeOrItsOwn) {
  const auto ends = [](const TransferFunction& transfer) {
    return ValueRange{transfer.colors.front().value, transfer.colors.back().value};
  };
  const std::string rest = R"("map": "viridis", "opacities": [[0, 0.5]])";
  EXPECT_EQ(ends(parsed(document(rest))), kRange);
  EXPECT_EQ(ends(parsed(document(R"("map_range": [50, 60], )" + rest))), (ValueRange{50, 60}));
  EXPECT_EQ(ends(parsed(document(R"("domain": "unit", )" + rest))), kRange);
  EXPECT_EQ(ends(parsed(document(R"("domain": "unit", "map_range": [0.5, 0.75], )" + rest))),
            (ValueRange{100, 150}));
  EXPECT_EQ(colorAt(parsed(document(rest)), 200), colorMap("viridis")->back().rgb);
}

TEST(TransferFile, opacityOfALongerUnitIsThatOfManyVoxels) {
  const auto transfer = parsed(
      document(R"("map": "grey", "unit_length_vox": 8, "opacities": [[0, 0], [1, 0.3], [2, 1]])"));
  EXPECT_EQ(opacityAt(transfer, 0), 0);
  EXPECT_EQ(opacityAt(transfer, 2), 1);
  EXPECT_NEAR(1 - std::pow(1 - opacityAt(transfer, 1), 8), 0.3, 1e-14);
  EXPECT_LT(transfer.opacities.size(), 100);
  // Between the points, too, where the opacities of eight voxels are linear; but for the last ten
  // thousandth, where the curve is steeper than any line.
  for (double value = 0; value < 1.9999; value += 0.0007) {
    const double given = value < 1 ? 0.3 * value : 0.3 + 0.7 * (value - 1);
    EXPECT_NEAR(opacityAt(transfer, value), 1 - std::pow(1 - given, 1.0 / 8), 1.1e-3) << value;
  }
}

TEST(TransferFile, whatIsWrittenIsReadBackBitForBit) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 50; ++round) {
    TransferFunction transfer;
    transfer.name = round == 0 ? "" : "a \"name\"\n with \\ and \xc3\xa9";
    double value = -1e3 * unit(random);
    for (int i = 0; i < 6; ++i) {
      transfer.colors.push_back({value, {unit(random), unit(random) / 3, 1}});
      transfer.opacities.push_back({value, std::pow(unit(random), 30)});
      if (i % 2 == 0) value += unit(random) * std::pow(10, 20 * unit(random) - 10);
    }
    const std::string json = writeTransferFunction(transfer);
    EXPECT_THAT(json, Not(HasSubstr("\n")));
    EXPECT_TRUE(same(parseTransferFunction(json, "elsewhere", {-5, 5}), transfer)) << json;
  }
  const auto threshold = thresholdTransfer(40, {0, 255});
  EXPECT_TRUE(same(parsed(writeTransferFunction(threshold)), threshold));
}

TEST(TransferFile, labelsAreWrittenAndReadBack) {
  const TransferFunction labels = labelsTransfer(labelStyles({0, 3, 90}, 0));
  const TransferFunction again = parsed(writeTransferFunction(labels));
  EXPECT_TRUE(same(again, labels));
  EXPECT_TRUE(again.labels);
  EXPECT_FALSE(parsed(document(R"("map": "grey", "opacities": [[0, 1]])")).labels);
}

TEST(TransferFile, aMapThatIsAskedForReplacesTheColoursOfOurOwn) {
  const std::string json = document(
      R"("colors": [[40, 1, 0.5, 0], [100, "#336699"]], "opacities": [[40, 0.01], [60, 1]])");
  const TransferFunction transfer = parseTransferFunction(json, "f.json", kRange, "viridis");
  EXPECT_EQ(transfer.colors.front().value, 40);
  EXPECT_EQ(transfer.colors.back().value, 100);
  EXPECT_EQ(colorAt(transfer, 100), colorMap("viridis")->back().rgb);
  EXPECT_EQ(opacityAt(transfer, 60), 1);
  EXPECT_THROW(parseTransferFunction(json, "f.json", kRange, "jet"), Error);
}

TEST(TransferFile, nameThatIsNoUtf8IsStillWritten) {
  EXPECT_EQ(parsed(writeTransferFunction({{{0, {}}}, {{0, 1}}, "caf\xe9"})).name,
            "caf\xef\xbf\xbd");
}

TEST(TransferFile, readsFromAFile) {
  const TempFolder folder;
  writeFile(folder / "t.json", document(R"("map": "grey", "opacities": [[0, 0.5]])"));
  EXPECT_EQ(readTransferFunction(folder / "t.json", kRange).name, (folder / "t.json").string());
}

TEST(TransferFile, fileThatCannotBeReadIsAnError) {
  const TempFolder folder;
  EXPECT_THROW(readTransferFunction(folder / "missing.json", kRange), Error);
  EXPECT_THROW(readTransferFunction(folder.path(), kRange), Error);
  writeFile(folder / "empty.json", "");
  EXPECT_THROW(readTransferFunction(folder / "empty.json", kRange), Error);
  EXPECT_THROW(readTransferFunction("/dev/zero", kRange), Error);
}

TEST(TransferFile, examplesInTheDocumentationWork) {
  const std::string page =
      readFile(std::filesystem::path(SLUICE_SOURCE_DIR) / "docs" / "transfer-functions.md");
  const std::string open = "```json\n", close = "```";
  int examples = 0;
  for (size_t at = page.find(open); at != page.npos; at = page.find(open, at)) {
    at += open.size();
    const std::string example = page.substr(at, page.find(close, at) - at);
    EXPECT_EQ(failureOf(example), "") << example;
    ++examples;
  }
  EXPECT_EQ(examples, 3);
}

TEST(TransferFile, documentationListsTheMaps) {
  const std::string page =
      readFile(std::filesystem::path(SLUICE_SOURCE_DIR) / "docs" / "transfer-functions.md");
  for (const std::string_view name : colorMapNames()) {
    EXPECT_THAT(page, HasSubstr("`" + std::string(name) + "`"));
  }
}

struct Bad {
  std::string json, expected;
};

TEST(TransferFile, badInputIsOneLineWithFieldExpectedAndFound) {
  const std::string rest = R"(, "map": "grey", "opacities": [[0, 0.5]])";
  const std::string map = R"("map": "grey", )";
  const std::vector<Bad> cases = {
      {"", "expected JSON"},
      {"{", "expected JSON"},
      {"NaN", "expected JSON"},
      {"\xff\xfe\n\x01", "expected JSON"},
      {"12", "expected an object at the top, found 12"},
      {"null", "expected an object at the top, found null"},
      {"{}", "expected the field /sluice_transfer_function, found none"},
      {R"({"sluice_transfer_function": 2)" + rest + "}",
       "expected version 1 at /sluice_transfer_function, found 2"},
      {R"({"sluice_transfer_function": "1")" + rest + "}", "expected a number at /sluice_tr"},
      {document(R"("opacitys": 3)" + rest), "found 'opacitys'"},
      {document(R"("domain": "percent")" + rest),
       "expected 'values' or 'unit' at /domain, found 'percent'"},
      {document(R"("domain": 1)" + rest), "expected a text at /domain, found 1"},
      {document(R"("name": [])" + rest), "expected a text at /name, found an array of 0"},
      {document(R"("unit_length_vox": 0)" + rest), "expected a length above 0 at /unit_length_vox"},
      {document(R"("unit_length_vox": -1)" + rest), "found -1"},
      {document(R"("map_range": [2, 1])" + rest), "expected [lo, hi] with lo <= hi at /map_range"},
      {document(R"("map_range": [2])" + rest), "expected [lo, hi] at /map_range"},
      {document(R"("map_range": 7)" + rest), "expected an array at /map_range, found 7"},
      {document(R"("colors": [[0, 0, 0, 0]])" + rest), "found both"},
      {document(R"("opacities": [[0, 1]])"), "found none"},
      {document(R"("map": "jet", "opacities": [[0, 1]])"), "f.json: /map: expected one of viridis"},
      {document(R"("map": 3, "opacities": [[0, 1]])"), "expected a text at /map"},
      {document(R"("map": "grey")"), "expected the field /opacities, found none"},
      {document(map + R"("opacities": [])"), "expected at least one point at /opacities"},
      {document(map + R"("opacities": {})"), "expected an array at /opacities"},
      {document(map + R"("opacities": [5])"), "expected [value, opacity] at /opacities/0, found 5"},
      {document(map + R"("opacities": [[1, 0.5, 0]])"), "at /opacities/0, found an array of 3"},
      {document(map + R"("opacities": [[1, 1.5]])"),
       "expected a number in 0..1 at /opacities/0/1, found 1.5"},
      {document(map + R"("opacities": [[1, -0.5]])"), "found -0.5"},
      {document(map + R"("opacities": [[1, null]])"), "expected a number at /opacities/0/1"},
      {document(map + R"("opacities": [["1", 1]])"), "at /opacities/0/0, found '1'"},
      {document(map + R"("opacities": [[1, NaN]])"), "expected JSON"},
      {document(map + R"("opacities": [[1e999, 1]])"), "expected JSON"},
      {document(map + R"("opacities": [[2, 0], [1, 1]])"),
       "expected 2 or more, as points ascend at /opacities/1/0, found 1"},
      {document(R"("opacities": [[0, 1]], "colors": [[0, 0, 0, 2]])"), "at /colors/0/3, found 2"},
      {document(R"("opacities": [[0, 1]], "colors": [[0, 0, 0]])"),
       "expected [value, r, g, b] or [value, '#rrggbb'] at /colors/0"},
      {document(R"("opacities": [[0, 1]], "colors": [[0, "red"]])"),
       "expected a colour as '#rrggbb' at /colors/0/1, found 'red'"},
      {document(R"("opacities": [[0, 1]], "colors": [[0, "#12345g"]])"), "found '#12345g'"},
      {document(R"("opacities": [[0, 1]], "colors": [[0, "#\n2345\u0000"]])"), "found '#?2345?'"},
      {document(R"("opacities": [[0, 1]], "map_range": [0, 1], "colors": [[0, "#123456"]])"),
       "expected no map_range without a map"},
  };
  for (const Bad& bad : cases) {
    EXPECT_THAT(failureOf(bad.json),
                AllOf(StartsWith("f.json: "), HasSubstr(bad.expected), Not(HasSubstr("\n"))))
        << bad.json;
    EXPECT_LT(failureOf(bad.json).size(), 400U) << bad.json;
  }
}

TEST(TransferFile, deepNestingIsAnError) {
  for (const char* open : {"[", "{\"a\":"}) {
    std::string json;
    for (int i = 0; i < 200000; ++i) json += open;
    EXPECT_THAT(failureOf(json), HasSubstr("levels of nesting"));
  }
}

TEST(TransferFile, anyTruncationIsAnError) {
  const std::string json = writeTransferFunction(thresholdTransfer(40, {0, 255}));
  for (size_t length = 0; length < json.size(); ++length) {
    EXPECT_NE(failureOf(json.substr(0, length)), "") << length;
  }
}

TEST(TransferFile, damageIsAnErrorOrAValidTransferFunction) {
  std::mt19937 random(17);
  const std::string good = writeTransferFunction(thresholdTransfer(40, {0, 255}));
  int errors = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string json = good;
    for (int i = 0; i < 3; ++i) json[random() % json.size()] = static_cast<char>(random() % 256);
    try {
      validate(parsed(json), "damaged");
    } catch (const Error& error) {
      ++errors;
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    }
  }
  EXPECT_GT(errors, 1000);
}

TEST(TransferFile, readsGradientOpacities) {
  const std::string both = R"("map": "grey", "opacities": [[0, 0.5]], )";
  const auto transfer = parsed(document(
      both + R"("gradient_opacities": [[0, 0], [10, [[50, 0.25], [100, 0.75]]], [30, 1]])"));
  ASSERT_EQ(transfer.gradients.size(), 3U);
  EXPECT_EQ(gradientFactorAt(transfer, 70, 0), 0);
  EXPECT_DOUBLE_EQ(gradientFactorAt(transfer, 75, 10), 0.5);
  EXPECT_DOUBLE_EQ(gradientFactorAt(transfer, 100, 20), 0.875);
  EXPECT_EQ(gradientFactorAt(transfer, 0, 1000), 1);
  // Shares of the range of 200: magnitudes without its start.
  const auto unit = parseTransferFunction(
      document(both +
               R"("domain": "unit", "gradient_opacities": [[0, 0], [0.1, [[0.5, 1], [1, 0]]]])"),
      "f", {100, 300});
  ASSERT_EQ(unit.gradients.size(), 2U);
  EXPECT_DOUBLE_EQ(unit.gradients[1].magnitude, 20);
  EXPECT_DOUBLE_EQ(gradientFactorAt(unit, 250, 20), 0.5);
  EXPECT_TRUE(parsed(document(R"("map": "grey", "opacities": [[0, 0.5]])")).gradients.empty());
}

TEST(TransferFile, gradientOpacitiesAreWrittenAndReadBack) {
  TransferFunction transfer = thresholdTransfer(40, {0, 240}, 0.05);
  transfer.gradients = {{0.1, {{1.0 / 3, 0.7}, {2, 0.1}}}, {7, {{0, 1}}}};
  EXPECT_TRUE(same(parsed(writeTransferFunction(transfer)), transfer));
}

TEST(TransferFile, rejectsGradientOpacitiesByPlace) {
  const auto failure = [](const std::string& list) {
    return failureOf(
        document(R"("map": "grey", "opacities": [[0, 0.5]], "gradient_opacities": )" + list));
  };
  EXPECT_THAT(failure("[]"), HasSubstr("1 to 16"));
  EXPECT_THAT(failure("3"), HasSubstr("gradient_opacities"));
  EXPECT_THAT(failure("[[1, 0], [1, 1]]"), HasSubstr("/gradient_opacities/1/0"));
  EXPECT_THAT(failure("[[-1, 0]]"), HasSubstr("0 or more"));
  EXPECT_THAT(failure("[[1, 2]]"), HasSubstr("/gradient_opacities/0/1"));
  EXPECT_THAT(failure("[[1, []]]"), HasSubstr("at least one point"));
  EXPECT_THAT(failure("[[1, [[0, 1], 5]]]"), HasSubstr("[value, factor]"));
  EXPECT_THAT(failure("[[1, [[2, 1], [1, 1]]]]"), HasSubstr("ascend"));
  EXPECT_THAT(failure("[[1]]"), HasSubstr("[magnitude, factor]"));
}

}  // namespace
}  // namespace sluice::transfer_file_test

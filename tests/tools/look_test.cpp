// The look that is chosen without options, and that the printed options reproduce it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

#include "io/pictures/exr_file.h"
#include "io/pictures/png_file.h"
#include "tests/tools/kinds_of_volumes.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string attributeOf(const std::filesystem::path& picture, const std::string& name) {
  for (const auto& [attribute, text] : readExr(picture).attributes)
    if (attribute == name) return text;
  return "";
}

std::string lookOptions(const nlohmann::json& report) {
  return report["look"]["options"].get<std::string>();
}

std::vector<std::string> parts(const std::string& list) {
  std::vector<std::string> result;
  std::istringstream in(list);
  for (std::string part; std::getline(in, part, ',');) result.push_back(part);
  return result;
}

// The part of a look's options from one to the next.
std::string optionOf(const std::string& options, const std::string& name) {
  const size_t at = options.find(name + " ");
  return at == std::string::npos ? "" : options.substr(at, options.find(" --", at) - at);
}

TEST(Look, optionsOfWhatWasChosenGiveTheSamePicture) {
  const Program program;
  for (const Kind& kind : kinds()) {
    SCOPED_TRACE(kind.file);
    writeFile(program.folder / kind.file, kind.bytes);
    const std::string line = "render " + kind.file + " --size 48x48 ";
    const auto chosen = program.json(line + "-o chosen.png");
    EXPECT_THAT(chosen["look"]["name"].get<std::string>(), HasSubstr(kind.name));
    const std::string options = lookOptions(chosen);
    const auto again = program.json(line + "-o again.png " + options);
    EXPECT_EQ(lookOptions(again), options);
    const std::string picture = readFile(program.folder / "chosen.png");
    EXPECT_EQ(picture, readFile(program.folder / "again.png")) << options;
    // There is something to see, and it is no flat disc.
    const Rgba8Picture seen = readPng(program.folder / "chosen.png");
    int shown = 0;
    for (size_t i = 3; i < seen.rgba.size(); i += 4) shown += seen.rgba[i] > 40 ? 1 : 0;
    EXPECT_GT(shown, 48 * 48 / 50) << options;
  }
}

TEST(Look, doesNotDependOnTheSizeOfBlocks) {
  const Program program;
  for (const Kind& kind : kinds()) {
    writeFile(program.folder / kind.file, kind.bytes);
    const auto lookWith = [&](const char* block) {
      return lookOptions(
          program.json("render " + kind.file + " --size 16x16 -o a.png --block " + block));
    };
    const std::string small = lookWith("8");
    EXPECT_EQ(lookWith("16"), small) << kind.file;
    EXPECT_EQ(lookWith("64"), small) << kind.file;
  }
}

TEST(Look, isSaidByRenderInfoAndTheReport) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " --size 32x32 -o a.exr";
  const CommandResult said = program.run(line);
  ASSERT_EQ(said.status, 0) << said.output;
  const std::string options = lookOptions(program.json(line));
  EXPECT_THAT(said.output, HasSubstr("look: " + options + "\n"));
  EXPECT_EQ(attributeOf(program.folder / "a.exr", "look"), options);
  const std::string of_info = program.json(std::string("info ") + kSmall)["look"]["options"];
  EXPECT_EQ(options.substr(0, of_info.size()), of_info) << "info knows no picture's size";
  EXPECT_THAT(program.run(std::string("info ") + kSmall).output, HasSubstr(of_info));
}

TEST(Look, isLitUnlessToldOtherwise) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " --threshold 90 -o a.png --size ";
  EXPECT_THAT(lookOptions(program.json(line + "24x24")), HasSubstr("--shade --step 0.5"));
  EXPECT_THAT(lookOptions(program.json(line + "200x200")), HasSubstr("--step 0.25"));
  EXPECT_THAT(lookOptions(program.json(line + "200x200 --step 1")), HasSubstr("--step 1"));
  const auto unlit = program.json(line + "24x24 --no-shade");
  EXPECT_THAT(lookOptions(unlit), HasSubstr("--no-shade"));
  EXPECT_EQ(unlit["look"]["lit"], false);
  EXPECT_EQ(program.run(line + "24x24 --shade --no-shade").status, 2);
}

TEST(Look, mapSetsColoursAlone) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " --size 24x24 -o a.png ";
  const std::string plain = lookOptions(program.json(line));
  const std::string viridis = lookOptions(program.json(line + "--map viridis"));
  EXPECT_THAT(viridis, HasSubstr("--map viridis"));
  for (const char* option : {"--opacities", "--range"}) {
    EXPECT_NE(optionOf(plain, option), "");
    EXPECT_EQ(optionOf(viridis, option), optionOf(plain, option));
  }
}

TEST(Look, mapIsFoundInAParaviewFileOrReplacesItsColours) {
  const Program program;
  const auto mapOf = [](const std::string& name) {
    return R"({"Name": ")" + name +
           R"(", "ColorSpace": "RGB", "RGBPoints": [40, 1, 0, 0, 200, 0, 0, 1],
              "Points": [40, 0, 0.5, 0, 200, 0.3, 0.5, 0]})";
  };
  writeFile(program.folder / "one.json", mapOf("Sunset"));
  writeFile(program.folder / "two.json", "[" + mapOf("Sunset") + "," + mapOf("My dawn") + "]");
  const std::string line = std::string("render ") + kSmall + " --size 24x24 -o a.exr ";
  const auto transferWith = [&](const std::string& options) {
    const CommandResult result = program.run(line + options);
    EXPECT_EQ(result.status, 0) << result.output;
    return nlohmann::json::parse(attributeOf(program.folder / "a.exr", "transferFunction"));
  };
  const auto sunset = transferWith("--transfer one.json");
  EXPECT_EQ(transferWith("--transfer two.json --map Sunset"), sunset);
  EXPECT_EQ(transferWith("--map 'My dawn' --transfer two.json")["name"], "My dawn");
  EXPECT_EQ(transferWith("--transfer one.json --map Sunset"), sunset);
  const auto viridis = transferWith("--transfer one.json --map viridis");
  EXPECT_EQ(viridis["opacities"], sunset["opacities"]);
  EXPECT_NE(viridis["colors"], sunset["colors"]);
  EXPECT_EQ(viridis["colors"].front()[0], 40);
  EXPECT_EQ(viridis["colors"].back()[0], 200);
  for (const char* options : {"two.json", "two.json --map viridis", "one.json --map dusk"}) {
    const CommandResult result = program.run(line + "--transfer " + options);
    EXPECT_EQ(result.status, 1) << options;
    EXPECT_THAT(result.output, HasSubstr("Sunset")) << "which names there are";
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
  }
}

TEST(Look, ofBenchesIsPlain) {
  const Program program;
  const std::string line = std::string("bench render ") + kSmall + " --size 24x24 --frames 1";
  const auto range = program.json(std::string("info ") + kSmall)["value_range"];
  const double fifth = std::lerp(range[0].get<double>(), range[1].get<double>(), 0.2);
  const std::string plain = lookOptions(program.json(line));
  EXPECT_EQ(plain, fmt::format("--threshold {} --opacity 0.05 --map ct-bone --no-shade", fifth));
  EXPECT_EQ(lookOptions(program.json(line + fmt::format(" --threshold {}", fifth))), plain);
  for (const char* command : {"bench", "bench render", "bench threshold", "bench algorithms"})
    EXPECT_THAT(program.run(std::string(command) + " --help").output,
                HasSubstr("pictures are plain"));
}

TEST(Look, oneColourIsARampOfOpacityInIt) {
  const Program program;
  const std::string line =
      std::string("render ") + kSmall + " --size 32x32 -o a.png --force --no-shade ";
  const std::string plain = lookOptions(program.json(line));
  for (const char* map : {"green", "'#ff8800'", "ff8800"}) {
    const std::string options = lookOptions(program.json(line + "--map " + map));
    EXPECT_EQ(optionOf(options, "--map"), std::string("--map ") + map);
    EXPECT_EQ(optionOf(options, "--opacities"), optionOf(plain, "--opacities"));
    const std::array<int, 3> rgb =
        map == std::string("green") ? std::array{0, 255, 0} : std::array{255, 136, 0};
    const Rgba8Picture seen = readPng(program.folder / "a.png");
    int shown = 0;
    for (size_t i = 0; i < seen.rgba.size(); i += 4) {
      if (seen.rgba[i + 3] < 20) continue;
      ++shown;
      for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen.rgba[i + c], rgb[c], 6);
    }
    EXPECT_GT(shown, 30);
    // Options that were printed give the same picture.
    const std::string picture = readFile(program.folder / "a.png");
    program.json(line + options);
    EXPECT_EQ(readFile(program.folder / "a.png"), picture);
  }
  // If a pixel shows one value, its colour tells which.
  program.json(line + "--mode mip --map green");
  const Rgba8Picture mip = readPng(program.folder / "a.png");
  int least = 255, most = 0;
  for (size_t i = 0; i < mip.rgba.size(); i += 4) {
    if (mip.rgba[i + 3] < 255) continue;
    EXPECT_EQ(mip.rgba[i] + mip.rgba[i + 2], 0);
    least = std::min<int>(least, mip.rgba[i + 1]);
    most = std::max<int>(most, mip.rgba[i + 1]);
  }
  EXPECT_GT(most, least + 100);
  EXPECT_EQ(program.run(line + "--map gren").status, 2);
}

// Everything but the opacity of a voxel, which a ray of the same optical depth determines.
TEST(Look, ofAPhantomIsTheSameAtEveryResolution) {
  const Program program;
  const auto lookAt = [&](int side) {
    const auto info =
        program.json(fmt::format("info synth:phantom,dims={0}x{0}x{0}", side))["look"];
    std::vector<double> numbers;  // values, and optical depths of the volume's side
    std::string options = info["options"];
    EXPECT_THAT(options, HasSubstr("--map plaster --range "));
    const std::string points = optionOf(options, "--opacities").substr(12);
    for (const std::string& point : parts(points)) {
      const size_t colon = point.find(':');
      numbers.push_back(std::stod(point.substr(0, colon)));
      numbers.push_back(-side * std::log1p(-std::stod(point.substr(colon + 1))));
    }
    return numbers;
  };
  const std::vector<double> finest = lookAt(512);
  for (const int side : {64, 128, 256}) {
    std::vector<double> expected = finest;
    expected.back() = std::min(expected.back(), side * std::log(2));  // an opacity of 0.5 at most
    const std::vector<double> found = lookAt(side);
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i)
      // Shells thinner than a voxel hold a larger share of a coarse volume.
      EXPECT_NEAR(found[i], expected[i], i % 2 == 0 ? 0.02 * 255 : 0.3 * expected[i] + 0.01)
          << side << ", number " << i;
  }
}

TEST(Look, whatIsUpIsAskedForWhereTheVolumeDoesNotSay) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " --size 32x32 -o a.png --force ";
  EXPECT_THAT(program.run(line).output, HasSubstr("\n"
                                                  "up: not in the file; --up 0,0,1"));
  for (const char* options : {"--up 0,0,1", "--view plain", "--eye 0,0,-300 --target 0,0,0", "-q"})
    EXPECT_THAT(program.run(line + options).output, Not(HasSubstr("up: "))) << options;
}

TEST(Look, modesTakeTheWholeRange) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " --size 24x24 -o a.png ";
  const auto range = program.json(std::string("info ") + kSmall)["value_range"];
  for (const std::string mode : {"mip", "minip", "average"}) {
    const auto report = program.json(line + "--mode " + mode);
    EXPECT_EQ(lookOptions(report),
              fmt::format("--map grey --range {},{}{}", range[0].get<double>(),
                          range[1].get<double>(), mode == "average" ? " --step 1" : ""));
    EXPECT_EQ(report["blocks"]["white"], 0) << "everything takes part";
    const std::string own = lookOptions(program.json(line + "--threshold 90 --mode " + mode));
    EXPECT_THAT(own, HasSubstr("--threshold 90"));
    EXPECT_THAT(own, HasSubstr("--map grey"));
  }
}

TEST(Look, thresholdBeyondTheValuesIsAWarning) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " --size 24x24 -o a.png --threshold ";
  const CommandResult high = program.run(line + "300"), low = program.run(line + "-5");
  EXPECT_EQ(high.status, 0);
  EXPECT_THAT(high.output,
              HasSubstr("warning: --threshold 300: nothing shows, the values are 0 to"));
  EXPECT_THAT(low.output, HasSubstr("everything shows"));
  EXPECT_THAT(program.run(line + "90").output, Not(HasSubstr("warning")));
}

TEST(Look, opacityBesideAFileIsAWarning) {
  const Program program;
  std::ofstream(program.folder.path() / "t.json")
      << R"({"sluice_transfer_function": 1, "map": "grey", "opacities": [[40, 0], [90, 0.5]]})";
  const std::string line = std::string("render ") + kSmall + " --size 24x24 -o a.png --force ";
  EXPECT_THAT(program.run(line + "--transfer t.json --opacity 0.3").output,
              HasSubstr("warning: --opacity 0.3: changes nothing, since --transfer has opacities"));
  EXPECT_THAT(program.run(line + "--transfer t.json").output, Not(HasSubstr("warning")));
}

TEST(Look, labelsThatNoTableTellsApartAreAWarning) {
  const Program program;
  const auto warningOf = [&](float greatest) {
    std::vector<float> voxels(size_t{8} * 8 * 8);
    for (size_t i = 0; i < voxels.size(); ++i)
      voxels[i] = std::array{0.0F, 1.0F, 17.0F, greatest}[i / 2 % 4];
    std::ofstream(program.folder / "l_8x8x8_float32.raw", std::ios::binary)
        .write(reinterpret_cast<const char*>(voxels.data()),
               static_cast<std::streamsize>(4 * voxels.size()));
    return program.run("render l_8x8x8_float32.raw -o a.png --force --size 32 --labels").output;
  };
  EXPECT_THAT(warningOf(1048575), Not(HasSubstr("warning")));
  EXPECT_THAT(warningOf(614454272),
              HasSubstr("warning: labels from 0 to 614454272: 3 of them may show as another label "
                        "or not at all, since numbers that span more than 1048576"));
}

TEST(Look, labelsThatNoVoxelHasAreAWarning) {
  const Program program;
  std::string voxels(size_t{8} * 8 * 8, '\0');
  for (size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<char>(i % 3);
  std::ofstream(program.folder / "l_8x8x8_uint8.raw", std::ios::binary) << voxels;
  const auto labelled = [&](const std::string& more) {
    return program.run("render l_8x8x8_uint8.raw -o a.png --force --size 32 " + more).output;
  };
  const std::string plain = labelled("--labels");
  EXPECT_THAT(plain, Not(HasSubstr("warning")));
  const std::string line = labelled("--label 12345=red --label 1=red");
  EXPECT_THAT(line, HasSubstr("sluice: warning: --label 12345=red: no voxel has this label\n"));
  EXPECT_THAT(line, HasSubstr("look: --labels --label 1=red "));
  EXPECT_THAT(labelled("--label 5-9=red"), HasSubstr("no voxel has one of these labels"));
  EXPECT_THAT(labelled("--label 1-9=red --label all=:0.5"), Not(HasSubstr("warning")));
  const CommandResult half = program.run("render l_8x8x8_uint8.raw -o b.png --label 1.7=red");
  EXPECT_EQ(half.status, 2);
  EXPECT_THAT(half.output, HasSubstr("--label: expected a label N, a whole number"));
}

TEST(Look, optionsThatContradictEachOtherAreRefused) {
  const Program program;
  const std::string line = std::string("render ") + kSmall + " -o a.png ";
  for (const char* options :
       {"--eye 1,2,300 --target 1,2,3 --azimuth 10", "--eye 1,2,300 --target 1,2,3 --elevation 10",
        "--threshold 4 --labels", "--opacities 3:0,5:1 --threshold 4",
        "--opacities 3:0 --opacity 0.1", "--opacities 5:0,3:1", "--opacities 5:2", "--opacities 5",
        "--range 3,3", "--range 3"}) {
    const CommandResult result = program.run(line + options);
    EXPECT_EQ(result.status, 2) << options << ": " << result.output;
  }
}

// --- series

std::vector<float> growing(int step) {
  std::vector<float> voxels;
  for (int64_t z = 0; z < kSide; ++z)
    for (int64_t y = 0; y < kSide; ++y)
      for (int64_t x = 0; x < kSide; ++x)
        voxels.push_back(static_cast<float>(
            std::max(0.0, (6.0 + 3 * step - fromCenter(x, y, z)) * (1 + step * step))));
  return voxels;
}

void writeSeries(const Program& program) {
  for (int step = 0; step < 4; ++step) {
    const std::vector<float> voxels = growing(step);
    writeFile(program.folder / fmt::format("s{}_40x40x40_float32.raw", step),
              std::string(reinterpret_cast<const char*>(voxels.data()), 4 * voxels.size()));
  }
}

TEST(Look, ofASeriesIsTheSameAtEveryStep) {
  const Program program;
  writeSeries(program);
  const auto lookAt = [&](int step, const std::string& options) {
    return lookOptions(program.json(fmt::format(
        "render s%d_40x40x40_float32.raw --size 24x24 -o a.png --time {} {}", step, options)));
  };
  const std::string first = lookAt(0, "");
  for (int step = 1; step < 4; ++step) EXPECT_EQ(lookAt(step, ""), first);
  EXPECT_NE(lookAt(0, "--this-step"), lookAt(3, "--this-step"));
  // A threshold's ramp ends at the top of all steps, or at the end of --range.
  const auto colorAt = [&](int step, const std::string& options) {
    program.json(
        fmt::format("render s%d_40x40x40_float32.raw --size 24x24 -o {}.exr --time {} "
                    "--threshold 1 --no-shade {}",
                    step, step, options));
    return attributeOf(program.folder / fmt::format("{}.exr", step), "transferFunction");
  };
  EXPECT_EQ(colorAt(0, ""), colorAt(3, ""));
  EXPECT_NE(colorAt(0, "--this-step"), colorAt(3, "--this-step"));
  EXPECT_EQ(colorAt(0, "--range 0,50"), colorAt(3, "--range 0,50"));
}

TEST(Look, ofASeriesGrowsAsTheSeriesDoes) {
  const Program program;
  writeSeries(program);
  double last = 0;
  for (int step = 0; step < 4; ++step) {
    const std::string name = fmt::format("g{}.png", step);
    ASSERT_EQ(program
                  .run(fmt::format("render s%d_40x40x40_float32.raw --size 48x48 --time {} -o {}",
                                   step, name))
                  .status,
              0);
    const Rgba8Picture picture = readPng(program.folder / name);
    double opacity = 0;
    for (size_t i = 3; i < picture.rgba.size(); i += 4) opacity += picture.rgba[i];
    EXPECT_GT(opacity, 1.1 * last) << step;
    last = opacity;
  }
}

}  // namespace
}  // namespace sluice

// Surfaces and looks of labels from the command line: pictures that hold for any blocks, blocks
// that are left out, and what is refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Looks : public testing::Test {
 protected:
  nlohmann::json report(const std::string& arguments) const {
    const CommandResult result =
        program_.run("render --force --size 96x80 -o a.png --report r.json " + arguments);
    EXPECT_EQ(result.status, 0) << result.output;
    std::ifstream in(program_.folder / "r.json");
    return nlohmann::json::parse(in, nullptr, false);
  }
  std::string refusal(const std::string& arguments, int status = 1) const {
    const CommandResult result = program_.run("render --force --size 64 -o a.png " + arguments);
    EXPECT_EQ(result.status, status) << result.output;
    EXPECT_TRUE(isOneLine(result.output) || status == 2) << result.output;
    return result.output;
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(program_.folder / name, std::ios::binary) << text;
  }
  std::string bytesOf(const std::string& name) const {
    std::ifstream in(program_.folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // Three slabs of labels 1, 2 and 3 along x, next to nothing.
  void writeLabels() const {
    std::string voxels;
    for (int i = 0; i < 64 * 20 * 20; ++i) voxels += static_cast<char>(std::min(i % 64 / 16, 3));
    write("labels.raw", voxels);
  }
  static constexpr const char* kLabels = "labels.raw --dims 64,20,20 --type u8 --block 8 ";

  const Program program_;
};

TEST_F(Looks, surfacesAreThoseOfAPictureWithoutAccelerations) {
  for (const char* device : {"cpu", "gl"})
    for (const char* more : {"", "--threshold 40 --opacity 0.02 ", "--projection perspective "}) {
      const nlohmann::json found = report(fmt::format(
          "{} --iso 100,180:0.4:ff8800 --block 16 --verify --device {} {}", kSmall, device, more));
      EXPECT_LE(found["verify"]["max_difference"].get<double>(), 1) << device << more;
      EXPECT_THAT(found["options"].dump() + found["look"].dump(), HasSubstr("100,180:0.4:ff8800"));
    }
}

TEST_F(Looks, blocksWithoutASurfaceAreNotRead) {
  const auto blocks = [&](const std::string& look) {
    return program_.json(fmt::format("plan {} --block 8 {}", kSmall, look))["read"]["blocks"]
        .get<int64_t>();
  };
  EXPECT_LT(blocks("--iso 250"), blocks("--threshold 1") * 0.8);
  EXPECT_GT(blocks("--iso 100"), 0);
}

// A greatest or mean number of several labels belongs to a label that no ray meets.
TEST_F(Looks, labelsAreRefusedInModesThatMixNumbers) {
  for (const std::string mode : {"mip", "minip", "average", "attenuated-mip", "depth-mip"})
    for (const std::string labels : {"--labels", "--label 3=ff8800"}) {
      SCOPED_TRACE(mode + " " + labels);
      EXPECT_THAT(
          refusal(fmt::format("synth:parts,dims=20x20x20 {} --mode {}", labels, mode), 2),
          HasSubstr(labels.substr(0, labels.find(' ')) +
                    " needs --mode composite, since other modes mix the numbers of labels"));
    }
}

TEST_F(Looks, surfacesAreRefusedWhereThereCanBeNone) {
  const std::string small = kSmall;
  EXPECT_THAT(refusal(small + " --iso 100 --mode mip", 2),
              HasSubstr("--iso needs --mode composite"));
  EXPECT_THAT(refusal(small + " --shadows --mode mip", 2),
              HasSubstr("--shadows needs --mode composite, since other modes are not lit"));
  EXPECT_THAT(refusal(small + " --occlusion-light --no-shade", 2),
              HasSubstr("--occlusion-light lights the picture; leave out --no-shade"));
  EXPECT_THAT(refusal(small + " --iso 100 --level 1"), HasSubstr("--level 1: there is 1 level"));
  EXPECT_THAT(
      refusal(small + " --iso 100:1:nocolour"),
      HasSubstr("--iso 100:1:nocolour: there is no colour nocolour; give RRGGBB or one of"));
  EXPECT_THAT(refusal(small + " --iso 100:2", 2), HasSubstr("--iso: expected up to 8 values T"));
  EXPECT_THAT(refusal(small + " --iso 1,2,3,4,5,6,7,8,9", 2), HasSubstr("expected up to 8 values"));
  EXPECT_THAT(refusal(small + " --iso 100 --labels", 2), HasSubstr("excludes"));
  const CommandResult none =
      program_.run("render --force -o a.png --size 64 " + small + " --iso 999");
  EXPECT_EQ(none.status, 0);
  EXPECT_THAT(none.output, HasSubstr("--iso 999: no surface, the values are"));
}

TEST_F(Looks, aTableOfAnotherVolumeIsWarnedOf) {
  writeLabels();
  write("other.txt", "0 0 0 0 0 0 0 \"Clear Label\"\n7 255 0 0 1 1 1 \"one\"\n");
  const auto said = [&](const std::string& look) {
    return program_.run(std::string("render --force --size 40 -o a.png ") + kLabels + look).output;
  };
  EXPECT_THAT(said("--labels-table other.txt"),
              HasSubstr("--labels-table other.txt: no label that it shows is in the volume, which "
                        "has 1, 2, 3; give the table of this volume, or leave it out"));
  write("other.txt", "0 0 0 0 0 0 0 \"Clear Label\"\n2 255 0 0 1 1 1 \"two\"\n");
  EXPECT_THAT(said("--labels-table other.txt"), Not(HasSubstr("no label")));
}

TEST_F(Looks, labelsHaveTheLooksOfATableAndOfOptions) {
  writeLabels();
  write("snap.txt", "# labels\n1 255 0 0 1 1 1 \"one\"\n2 0 255 0 0.3 1 1 \"two\"\n");
  write("slicer.ctbl", "1 one 255 0 0 255\n2 two 0 255 0 76.5\n");
  const std::string labels = kLabels;
  const auto picture = [&](const std::string& look) {
    EXPECT_EQ(program_.run("render --force --size 160x128 -o a.png " + labels + look).status, 0);
    return bytesOf("a.png");
  };
  const std::string table = picture("--labels-table snap.txt");
  EXPECT_EQ(table, picture("--labels-table slicer.ctbl"));
  EXPECT_EQ(table, picture("--label 1=ff0000 --label 2=00ff00:0.3 --label 3=:0"));
  EXPECT_EQ(table, picture("--label all=:0 --label 1=ff0000:1 --label 2=00ff00:0.3"));
  EXPECT_NE(table, picture("--labels-table snap.txt --label 2=:0.4"));
  EXPECT_NE(picture("--labels-table snap.txt --annotate"),
            picture("--label 1=ff0000 --label 2=00ff00:0.3 --label 3=:0 --annotate"));
  for (const char* device : {"cpu", "gl"})
    EXPECT_LE(report(labels + "--labels-table snap.txt --verify --device " +
                     device)["verify"]["max_difference"]
                  .get<double>(),
              1);
}

TEST_F(Looks, labelsThatATableHidesStayHiddenWithAnOpacity) {
  writeLabels();
  // ITK-SNAP's table hides a label by its second flag, and leaves the others out.
  write("snap.txt", "1 255 0 0 1 1 1 \"one\"\n2 0 255 0 0.5 0 1 \"two\"\n");
  write("slicer.ctbl", "1 one 255 0 0 255\n2 two 0 255 0 51\n");
  const std::string labels = kLabels;
  const auto picture = [&](const std::string& look) {
    EXPECT_EQ(program_.run("render --force --size 96x80 -o a.png " + labels + look).status, 0);
    return bytesOf("a.png");
  };
  const std::string hidden = picture("--label all=:0 --label 1=ff0000:0.2 --no-shade");
  EXPECT_EQ(hidden, picture("--labels-table snap.txt --opacity 0.2 --no-shade"));
  EXPECT_EQ(hidden, picture("--look 0:snap.txt,0.2"));
  const std::string whole = picture("--label all=:0 --label 1=ff0000:1 --no-shade");
  EXPECT_EQ(whole, picture("--look 0:snap.txt"));
  EXPECT_EQ(whole, picture("--labels-table snap.txt --opacity 1 --no-shade"));
  // The labels of a table keep the ratio of their opacities.
  const std::string half =
      picture("--label all=:0 --label 1=ff0000:0.5 --label 2=00ff00:0.1 --no-shade");
  EXPECT_EQ(half, picture("--labels-table slicer.ctbl --opacity 0.5 --no-shade"));
  EXPECT_EQ(half, picture("--look 0:slicer.ctbl --opacity 0.5"));
  // Without a table, the opacity is that of each label.
  EXPECT_EQ(picture("--labels --opacity 0.3 --no-shade"), picture("--look 0:labels,0.3"));
}

TEST_F(Looks, blocksOfLabelsThatDoNotShowAreNotRead) {
  writeLabels();
  const auto blocks = [&](const std::string& look) {
    return program_.json(std::string("plan ") + kLabels + look)["read"]["blocks"].get<int64_t>();
  };
  // A quarter of the volume, and the blocks that reach into it.
  EXPECT_LE(blocks("--label all=:0 --label 1=:1"), blocks("--labels") / 2);
}

TEST_F(Looks, wrongTablesAndLabelsAreNamed) {
  writeLabels();
  write("wrong.txt", "1 one 255 0 0 255\n2 two 0 256 0 255\n");
  const std::string labels = kLabels;
  EXPECT_THAT(refusal(labels + "--labels-table wrong.txt"),
              HasSubstr("wrong.txt: line 2: expected NUMBER R G B A VISIBLE"));
  EXPECT_THAT(refusal(labels + "--labels-table none.txt"), HasSubstr("none.txt"));
  EXPECT_THAT(refusal(labels + "--label 1=nocolour"), HasSubstr("there is no colour nocolour"));
  EXPECT_THAT(refusal(labels + "--label 1", 2), HasSubstr("--label: expected a label N"));
  EXPECT_THAT(refusal(labels + "--label 1=red --threshold 3", 2), HasSubstr("excludes"));
}

TEST_F(Looks, theLightComesFromWhereItIsAsked) {
  const std::string common = std::string(kSmall) + " --force --size 64 --threshold 40 --shade -o ";
  const auto picture = [&](const std::string& light) {
    EXPECT_EQ(program_.run("render " + common + "a.png " + light).status, 0);
    return bytesOf("a.png");
  };
  const std::string plain = picture("");
  EXPECT_EQ(plain, picture("--ambient 0.3 --diffuse 0.65 --specular 0.2"));
  EXPECT_NE(plain, picture("--light 60,10"));
  EXPECT_EQ(picture("--light 60,10"), picture("--light 420,10"));
  EXPECT_NE(plain, picture("--specular 0"));
  EXPECT_THAT(refusal(std::string(kSmall) + " --ambient 2", 2), HasSubstr("--ambient"));
}

TEST_F(Looks, matterTakesLightAway) {
  const std::string common = "--force --size 64 --threshold 40 --shade -o a.png ";
  const auto picture = [&](const std::string& light) {
    EXPECT_EQ(program_.run("render " + common + light + " " + kSmall).status, 0);
    return bytesOf("a.png");
  };
  const std::string plain = picture("");
  EXPECT_TRUE(plain == picture("--shadows=0 --occlusion-light=0"));
  EXPECT_TRUE(plain != picture("--shadows"));  // and the file after it is the volume
  EXPECT_TRUE(picture("--shadows") == picture("--shadows=1"));
  EXPECT_TRUE(picture("--shadows") != picture("--shadows=0.5"));
  EXPECT_TRUE(picture("--shadows") != picture("--shadows --light 70,0"));
  for (const char* device : {"cpu", "gl"}) {
    const nlohmann::json found =
        report(fmt::format("{} --threshold 40 --shade --shadows --occlusion-light=0.5 --block 16 "
                           "--verify --device {}",
                           kSmall, device));
    EXPECT_LE(found["verify"]["max_difference"].get<double>(), 1) << device;
    EXPECT_GE(found["frames"][0]["light"]["texels"][0].get<int64_t>(), 2) << found["frames"][0];
  }
  EXPECT_THAT(refusal(std::string(kSmall) + " --shadows=2", 2), HasSubstr("--shadows"));
  EXPECT_THAT(refusal(std::string(kSmall) + " --shadows --mode mip", 2),
              HasSubstr("--mode composite"));
  EXPECT_THAT(refusal(std::string(kSmall) + " --shadows --no-shade", 2), HasSubstr("--no-shade"));
  EXPECT_THAT(refusal(std::string(kSmall) + " --shadows --modulate --shade", 2),
              HasSubstr("--modulate"));
}

TEST_F(Looks, depthCuesAndJitterAreOptions) {
  const auto picture = [&](const std::string& more) {
    EXPECT_EQ(
        program_.run(fmt::format("render --force --size 64 -o a.png {} {}", kSmall, more)).status,
        0);
    return bytesOf("a.png");
  };
  const std::string plain = picture("");
  EXPECT_EQ(plain, picture("--depth-cueing=0 --jitter=0"));
  EXPECT_NE(plain, picture("--jitter"));
  EXPECT_EQ(picture("--depth-cueing"), picture("--depth-cueing=1"));
  EXPECT_NE(picture("--mode mip --map turbo"), picture("--mode depth-mip"));
  for (const char* device : {"cpu", "gl"})
    for (const char* more : {"--depth-cueing=0.7 --jitter", "--mode depth-mip",
                             "--iso 90:0.5 --depth-cueing --projection perspective"}) {
      const nlohmann::json found =
          report(fmt::format("{} {} --block 16 --verify --device {}", kSmall, more, device));
      EXPECT_LE(found["verify"]["max_difference"].get<double>(), 1) << device << more;
    }
  EXPECT_THAT(refusal(std::string(kSmall) + " --depth-cueing=2", 2), HasSubstr("--depth-cueing"));
  EXPECT_THAT(refusal(std::string(kSmall) + " --jitter --mode mip", 2),
              HasSubstr("--mode composite"));
}

TEST_F(Looks, attenuationDimsMaxima) {
  const auto picture = [&](const std::string& more) {
    EXPECT_EQ(
        program_.run(fmt::format("render --force --size 64 -o a.png {} {}", kSmall, more)).status,
        0);
    return bytesOf("a.png");
  };
  const std::string attenuated = picture("--mode attenuated-mip");
  EXPECT_EQ(attenuated, picture("--mode attenuated-mip --attenuation 0.05"));
  EXPECT_NE(attenuated, picture("--mode attenuated-mip --attenuation 0.5"));
  for (const char* device : {"cpu", "gl"})
    for (const char* projection : {"ortho", "perspective"}) {
      const nlohmann::json found = report(
          fmt::format("{} --mode attenuated-mip --attenuation 0.2 --block 16 --verify --device {} "
                      "--projection {}",
                      kSmall, device, projection));
      EXPECT_LE(found["verify"]["max_difference"].get<double>(), 1) << device << projection;
      EXPECT_THAT(found["look"].dump(), HasSubstr("--attenuation 0.2"));
    }
  EXPECT_THAT(refusal(std::string(kSmall) + " --attenuation -1", 2), HasSubstr("--attenuation"));
}

}  // namespace
}  // namespace sluice

// --verify and its checks: the same picture whatever the blocks, at the default fit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "io/pictures/exr_file.h"
#include "tests/tools/program.h"
#include "tools/commands/verification.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// A number of values that make a ball with a bump, off the middle, in blocks' worth of nothing.
std::string ballBytes(int64_t side) {
  std::string bytes;
  for (int64_t z = 0; z < side; ++z)
    for (int64_t y = 0; y < side; ++y)
      for (int64_t x = 0; x < side; ++x) {
        const auto at = [&](double u, double v, double w) {
          const auto s = static_cast<double>(side);
          return std::hypot(static_cast<double>(x) - u * s, static_cast<double>(y) - v * s,
                            static_cast<double>(z) - w * s) /
                 s;
        };
        const double ball = std::clamp(4 * (0.3 - at(0.4, 0.5, 0.55)), 0.0, 1.0);
        const double bump = std::clamp(8 * (0.1 - at(0.75, 0.62, 0.5)), 0.0, 1.0);
        bytes += static_cast<char>(std::lround(230 * std::max(ball, bump)));
      }
  return bytes;
}

// The largest difference of two pictures with their opacity, in 1/255 of linear light.
double difference(const std::filesystem::path& a, const std::filesystem::path& b) {
  const ExrContents one = readExr(a), other = readExr(b);
  double most = 0;
  for (size_t i = 0; i < one.picture.rgba.size(); ++i)
    most = std::max(most, 255.0 * std::abs(one.picture.rgba[i] - other.picture.rgba[i]));
  return one.picture.rgba.size() == other.picture.rgba.size() ? most : 1e9;
}

TEST(Verify, theDefaultPictureIsTheSameForAllBlocks) {
  const Program program;
  writeFile(program.folder / "ball_75x75x75_uint8.raw", ballBytes(75));
  for (const std::string& volume : {std::string("ball_75x75x75_uint8.raw"), std::string(kSmall)})
    for (const char* options : {"", " --no-shade", " --crop 0,0,0,40,30,30"}) {
      const std::string line = fmt::format("render {}{} --size 70x60 ", volume, options);
      for (const char* block : {"8", "16", "64"})
        program.json(fmt::format("{} -o {}.exr --force --block {}", line, block, block));
      EXPECT_LE(difference(program.folder / "16.exr", program.folder / "64.exr"), 0.25) << line;
      EXPECT_LE(difference(program.folder / "8.exr", program.folder / "64.exr"), 0.25) << line;
    }
}

TEST(Verify, agreesForAllWaysOfDrawing) {
  const Program program;
  writeFile(program.folder / "ball_75x75x75_uint8.raw", ballBytes(75));
  int seed = 0;
  for (const char* options :
       {"--block 16 --algorithm trimmed", "--block 64 --no-shade --projection perspective",
        "--block 32 --partition boxes --azimuth 200 --elevation 50",
        "--block 16 --occlusion clip --opacity-threshold 1", "--block 32 --mode mip",
        "--block 16 --threshold 90 --map green --annotate"}) {
    const auto report = program.json(fmt::format(
        "render ball_75x75x75_uint8.raw -o {}.png --size 160x130 --verify {}", seed++, options));
    EXPECT_LE(report["verify"]["max_difference"].get<double>(), 1) << options;
    EXPECT_EQ(report["verify"]["differing_pixels"], 0) << options;
    EXPECT_FALSE(report["verify"]["unchecked"].empty());
  }
}

TEST(Verify, saysWhatItCannotCheck) {
  const Program program;
  const CommandResult result =
      program.run(std::string("render ") + kSmall + " -o a.png --size 40x40 --verify");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("; not checked: the choice of the look, how cpu samples"));
}

// --- faults

// Leaves out every block but the first that shows something.
class FirstBlock : public BlockChooser {
 public:
  VisibleBlocksPtr choose(const BlockQuestion& question) override {
    WorkerPool pool(1);
    VisibleBlocks all = classify(*question.step.ranges, question.look->table, question.crop, pool);
    all.blocks.resize(1);
    return std::make_shared<const VisibleBlocks>(std::move(all));
  }
};

// A scene of a ball, drawn with one fault, and the result of verify().
class VerifyFaultTest : public testing::Test {
 protected:
  VerifyFaultTest() {
    const std::filesystem::path file = folder_ / "ball_75x75x75_uint8.raw";
    writeFile(file, ballBytes(75));
    volume_.inputs = {file.string()};
    look_.threshold = 90;
    resources_.block = 32;
    resources_.quiet = true;
    resources_.index_dir = (folder_ / "index").string();
    frame_.size = {60, 50};
    frame_.camera.view = ViewName::kThreeQuarter;
  }

  double differenceWith(double scale_of_fit, BlockChooser* chooser,
                        std::optional<double> time_limit_s = std::nullopt) {
    Scene scene = openScene(volume_, look_, resources_, frame_);
    std::vector<Camera> cameras{frame_.camera};
    fitCameras(cameras, std::nullopt,
               {{{scene.volume, scene.volume.step(), scene.look.transfer}}, frame_, false}, {},
               resources_, scene.pool);
    FrameOptions options = frame_;
    options.camera = cameras.front();
    options.camera.framing->reach *= scale_of_fit;
    scene.chooseBlocksBy(chooser);
    scene.session->setOptions(options);
    const Picture picture = scene.frame().picture;
    options.time_limit_s = time_limit_s;
    const VerifiedView view{.volume = volume_,
                            .resources = resources_,
                            .cameras = {frame_.camera},
                            .frame = 0,
                            .fit = std::nullopt,
                            .room = {},
                            .this_step = false,
                            .time = 0};
    return verify(scene, view, options, picture).max_difference;
  }

  TempFolder folder_;
  VolumeArguments volume_;
  LookArguments look_;
  ResourceArguments resources_;
  FrameOptions frame_;
};

TEST_F(VerifyFaultTest, isFoundWhereTheFitIsWrong) {
  EXPECT_LE(differenceWith(1, nullptr), 1);
  EXPECT_GT(differenceWith(1.1, nullptr), 10);
}

TEST_F(VerifyFaultTest, isFoundWhereBlocksAreMissing) {
  FirstBlock chooser;
  EXPECT_GT(differenceWith(1, &chooser), 10);
}

// Otherwise both pictures would lack the same.
TEST_F(VerifyFaultTest, thePlainPictureHasNoTimeLimit) {
  EXPECT_LE(differenceWith(1, nullptr, 0), 1);
}

}  // namespace
}  // namespace sluice

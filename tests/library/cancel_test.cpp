// Progress, cancelled work that leaves no trace, and threads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <latch>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "tests/library/library_support.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// A volume with more clusters than fit at once.
class SeveralClusters : public testing::Test {
 protected:
  inline static const RendererOptions kLittle{.memory_bytes = 24 << 20};
  SeveralClusters() : volume_("synth:shells,dims=160x160x160") {
    renderer_.emplace(volume_, LookOptions{.threshold = 60}, kLittle);
    expected_ = renderer_->draw(kSmall);
  }
  const Volume volume_;
  std::optional<Renderer> renderer_;
  Image expected_;
};

TEST_F(SeveralClusters, progressGoesFromNothingToAll) {
  std::vector<Progress> told;
  renderer_->draw(kSmall, [&](const Progress& so_far) { told.push_back(so_far); });
  ASSERT_GE(told.size(), 3U);
  for (size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(told[i].stage, Progress::Stage::kDrawing);
    EXPECT_EQ(told[i].done, i);
    EXPECT_EQ(told[i].total, told.size() - 1);
  }
}

TEST_F(SeveralClusters, aPictureThatIsCalledOffLeavesTheNextOneRight) {
  const auto cancelledAfter = [&](uint64_t clusters) {
    std::stop_source stop;
    try {
      renderer_->draw(
          kSmall,
          [&](const Progress& so_far) {
            if (so_far.done >= clusters) stop.request_stop();
          },
          stop.get_token());
    } catch (const Cancelled&) {
      return true;
    }
    return false;
  };
  for (uint64_t clusters = 0; clusters < 3; ++clusters) {
    EXPECT_TRUE(cancelledAfter(clusters)) << clusters;
    EXPECT_EQ(renderer_->draw(kSmall).rgba, expected_.rgba) << clusters;
    renderer_.emplace(volume_, LookOptions{.threshold = 60}, kLittle);  // nothing is there yet
  }
  EXPECT_FALSE(cancelledAfter(1000));
}

TEST_F(SeveralClusters, pictureAfterPictureIsCalledOffFromAnotherThread) {
  // Wherever it is by then, the picture is whole or called off.
  for (int i = 0; i < 20; ++i) {
    std::stop_source stop;
    const std::jthread other([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(3 * i));
      stop.request_stop();
    });
    try {
      EXPECT_EQ(renderer_->draw(kSmall, {}, stop.get_token()).rgba, expected_.rgba);
    } catch (const Cancelled&) {
    }
  }
  // Called off when the other thread knows it to be under way, it is called off.
  for (uint64_t clusters = 0; clusters < 3; ++clusters) {
    std::stop_source stop;
    std::latch reached(1), asked(1);
    const std::jthread other([&] {
      reached.wait();
      stop.request_stop();
      asked.count_down();
    });
    const auto progress = [&](const Progress& so_far) {
      if (so_far.done != clusters) return;
      reached.count_down();
      asked.wait();
    };
    EXPECT_THROW(renderer_->draw(kSmall, progress, stop.get_token()), Cancelled) << clusters;
  }
  EXPECT_EQ(renderer_->draw(kSmall).rgba, expected_.rgba);
}

TEST_F(SeveralClusters, whatTheProgressFunctionThrowsComesOut) {
  for (const uint64_t clusters : {0, 1}) {
    EXPECT_THROW(renderer_->draw(kSmall,
                                 [&](const Progress& so_far) {
                                   if (so_far.done == clusters) throw std::out_of_range("mine");
                                 }),
                 std::out_of_range);
    EXPECT_EQ(renderer_->draw(kSmall).rgba, expected_.rgba);
  }
}

TEST_F(SeveralClusters, theProgressFunctionMayNotCallTheRenderer) {
  EXPECT_THAT(
      errorOf([&] { renderer_->draw(kSmall, [&](const Progress&) { renderer_->draw(kSmall); }); }),
      HasSubstr("progress function"));
  EXPECT_EQ(renderer_->draw(kSmall).rgba, expected_.rgba);
}

TEST(Renderer, threadsTakeTurnsAndRenderersStandSideBySide) {
  std::optional<Volume> volume(kShells);
  Renderer a(*volume, {.threshold = 90}), b(*volume, {.threshold = 90});
  volume.reset();  // each keeps it open
  const Image expected = a.draw(kSmall);
  std::vector<std::jthread> threads;
  std::array<int, 4> wrong{};
  for (size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 3; ++i)
        wrong[t] += (t % 2 == 0 ? a : b).draw(kSmall).rgba == expected.rgba ? 0 : 1;
    });
  threads.clear();
  EXPECT_THAT(wrong, testing::Each(0));
  Renderer moved = std::move(a);
  EXPECT_EQ(moved.draw(kSmall).rgba, expected.rgba);
  EXPECT_THROW(a.draw(), Error);      // NOLINT(bugprone-use-after-move): what is tested
  EXPECT_THROW(a.lookText(), Error);  // NOLINT(bugprone-use-after-move)
}

}  // namespace
}  // namespace sluice

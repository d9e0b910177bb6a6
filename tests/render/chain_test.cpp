// Values that plug into a frame's chain from outside: another device, another source of visible
// blocks, another time step, each in a few lines; and the values that are kept from frame to frame.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <unordered_map>

#include "src/render/session/planner.h"
#include "tests/render/blob_scene.h"
#include "tests/support/function_source.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

// A device whose picture is the number of boxes that it drew: it looks at no texel.
class BoxCountDevice : public Device {
 public:
  DeviceLimits limits() const override { return {4096, TexelPlace::kBorrowed}; }
  const char* backend() const override { return "count"; }
  const char* renderer() const override { return "boxes"; }
  void makeResident(uint64_t id, ChunkTexelsPtr texels) override { held_[id] = std::move(texels); }
  void evict(uint64_t id) override { held_.erase(id); }
  uint64_t uploadedBytes() const override { return 0; }
  uint64_t binds() const override { return 0; }
  void beginFrame(const FrameSetup&, const StopToken&) override {}
  void draw(std::span<const BoxDraw> boxes) override {
    for (const BoxDraw& box : boxes) EXPECT_TRUE(held_.contains(box.chunk));
    boxes_.insert(boxes_.end(), boxes.begin(), boxes.end());
  }
  std::vector<float> leastOpacity(const MapGrid& grid) override {
    return std::vector<float>(static_cast<size_t>(grid.side) * static_cast<size_t>(grid.side));
  }
  void stopOpaque() override {}
  uint64_t countSamples(std::span<const BoxDraw>) override { return 0; }
  uint64_t takenSamples() override { return 0; }
  Picture endFrame() override {
    Picture picture;
    picture.width = picture.height = 1;
    picture.rgba.assign(4, static_cast<float>(std::exchange(boxes_, {}).size()));
    return picture;
  }
  void cancelFrame() override { boxes_.clear(); }
  std::unordered_map<uint64_t, ChunkTexelsPtr> held_;

 private:
  std::vector<BoxDraw> boxes_;
};

TEST(ChainTest, anotherDevice) {
  const auto source = blobs();
  BoxCountDevice device;
  {
    RenderScene scene(device, *source, someTransfer(), {.block_vox = 8});
    const Frame frame = scene.frame(smallView());
    EXPECT_EQ(frame.picture.rgba.front(),
              static_cast<float>(frame.report.blocks.grey + frame.report.blocks.black));
    EXPECT_EQ(device.held_.size(), static_cast<size_t>(frame.report.chunks));
    EXPECT_EQ(frame.report.uploaded_bytes, 0U);
  }
  EXPECT_TRUE(device.held_.empty());
}

// A source of visible blocks that knows better than the min-max arrays: blocks and parts of blocks
// beyond a plane are not needed.
class HalfOfTheBlocks : public BlockChooser {
 public:
  explicit HalfOfTheBlocks(int64_t end) : end_(end) {}
  VisibleBlocksPtr choose(const BlockQuestion& question) override {
    if (chosen_ != nullptr) return chosen_;
    Box3 half = question.crop;
    half.hi.x = std::min(half.hi.x, end_);
    WorkerPool pool(1);
    VisibleBlocks all = classify(*question.step.ranges, question.look->table, question.crop, pool);
    std::erase_if(all.blocks, [&](ObjectBlock& block) {
      block.cells = intersect(block.cells, half);
      return block.cells.empty();
    });
    chosen_ = std::make_shared<const VisibleBlocks>(std::move(all));
    return chosen_;
  }

 private:
  const int64_t end_;
  VisibleBlocksPtr chosen_;
};

TEST(ChainTest, anotherSourceOfVisibleBlocks) {
  const auto source = blobs();
  PlainDevice device;
  RenderScene scene(device, *source, someTransfer(), {.block_vox = 8});
  FrameOptions options = smallView();
  options.crop = Box3{{0, 0, 0}, {21, 40, 36}};  // shows cells below 20
  const Frame expected = scene.frame(options);
  options.crop.reset();
  const Frame all = scene.frame(options);
  HalfOfTheBlocks half(20);
  scene.session().chooseBlocksBy(&half);
  const Frame frame = scene.frame(options);
  EXPECT_EQ(frame.picture.rgba, expected.picture.rgba);
  EXPECT_NE(frame.picture.rgba, all.picture.rgba);
  EXPECT_EQ(scene.frame(options).report.pages_loaded, 0U);
  scene.session().chooseBlocksBy(nullptr);
  EXPECT_EQ(scene.frame(options).picture.rgba, all.picture.rgba);
}

TEST(ChainTest, anotherTimeStep) {
  const auto source = makeSparseBlobs({.drift_vox = 6, .time_steps = 3});
  PlainDevice device;
  RenderScene scene(device, *source, someTransfer(), {.block_vox = 8});
  Session& session = scene.session();
  const FloatPicture first = scene.draw(smallView());
  PlainDevice others;
  for (int64_t time = 1; time < 3; ++time) {
    RenderScene other(others, *source, someTransfer(), {.block_vox = 8, .time = time});
    session.setTimeStep(other.step());
    const Frame frame = scene.frame(smallView());
    EXPECT_EQ(frame.picture.rgba, other.draw(smallView()).rgba) << "step " << time;
    EXPECT_NE(frame.picture.rgba, first.rgba);
  }
  session.setTimeStep(scene.step());
  const Frame again = scene.frame(smallView());
  EXPECT_EQ(again.picture.rgba, first.rgba);
  EXPECT_EQ(again.report.pages_loaded, 0U) << "all levels still hold the first step";
}

// Blocks of several time steps in one picture: of a block that has not changed since, the step that
// is held already is as good.
class StepOfEachBlock : public BlockChooser {
 public:
  VisibleBlocksPtr choose(const BlockQuestion& question) override {
    if (chosen_ == nullptr) {
      WorkerPool pool(1);
      VisibleBlocks blocks = classify(*question.step.ranges, question.look->table, question.crop,
                                      pool, question.step.time);
      for (ObjectBlock& block : blocks.blocks) block.name.time = block.name.block % 3;
      chosen_ = std::make_shared<const VisibleBlocks>(std::move(blocks));
    }
    return chosen_;
  }

 private:
  VisibleBlocksPtr chosen_;
};

TEST(ChainTest, blocksOfSeveralTimeSteps) {
  const auto still = blobs();  // the same at every step
  VolumeLayout layout = still->layout();
  layout.time_steps = 3;
  std::array<std::atomic<int>, 3> reads{};
  FunctionSource source(layout, [&](int64_t time, Vec3i v) {
    ++reads[static_cast<size_t>(time)];
    const Vec3i dims = layout.dims;
    const auto at = static_cast<size_t>((v.z * dims.y + v.y) * dims.x + v.x);
    return static_cast<double>(still->bytes()[at]);
  });
  for (const Algorithm algorithm : kAlgorithms) {
    PlainDevice device, mixed_device;
    RenderScene plain(device, source, someTransfer(), {.block_vox = 8});
    RenderScene mixed(mixed_device, source, someTransfer(), {.block_vox = 8, .pages = 12});
    FrameOptions options = smallView();
    options.algorithm = algorithm;
    const Frame expected = plain.frame(options);
    StepOfEachBlock chooser;
    mixed.session().chooseBlocksBy(&chooser);
    for (auto& count : reads) count = 0;
    EXPECT_EQ(mixed.frame(options).picture.rgba, expected.picture.rgba);
    for (const auto& count : reads) EXPECT_GT(count, 0) << "each step is read";
  }
}

TEST(ChainTest, valuesAreKeptUntilWhatTheyFollowFromChanges) {
  const auto source = blobs();
  PlainDevice device;
  const RenderScene scene(device, *source, someTransfer(), {.block_vox = 8});
  WorkerPool pool(1);
  ChunkNames names;
  Planner planner({{8, 8, 8}, 1, 64}, pool, names);
  const TimeStep step = scene.step();
  auto transfer = std::make_shared<const TransferFunction>(someTransfer());
  FrameOptions options = smallView();
  const LookPtr look = planner.look(step, transfer, options.mode);
  const FramePlanPtr plan = planner.planFor(step, transfer, options);
  const EyePosition eye{true, {0, 0, 1}};
  const DrawOrderPtr order = planner.order(plan, eye, Arrangement::kRows);
  options.camera.azimuth_deg += 20;
  options.size = {30, 20};
  EXPECT_EQ(planner.planFor(step, transfer, options), plan) << "a view changes no plan";
  EXPECT_EQ(planner.look(step, transfer, options.mode), look);
  EXPECT_EQ(planner.order(plan, eye, Arrangement::kRows), order);
  EXPECT_NE(planner.order(plan, {true, {0, 0, -1}}, Arrangement::kRows), order);
  options.algorithm = Algorithm::kTrimmed;
  EXPECT_NE(planner.planFor(step, transfer, options), plan);
  EXPECT_EQ(planner.look(step, transfer, options.mode), look) << "what stands left of it stays";
  transfer = std::make_shared<const TransferFunction>(someTransfer(90));
  EXPECT_NE(planner.look(step, transfer, options.mode), look);
  EXPECT_GT(planner.planFor(step, transfer, options)->textures.blocks.size(), 0U);
}

// Kept are the last ones alone: an hour of sliding a threshold takes no more than a minute of it.
TEST(ChainTest, whatIsNoLongerUsedGoes) {
  const auto source = blobs();
  PlainDevice device;
  const RenderScene scene(device, *source, someTransfer(), {.block_vox = 8});
  WorkerPool pool(1);
  ChunkNames names;
  Planner planner({{8, 8, 8}, 1, 64}, pool, names);
  std::weak_ptr<const FramePlan> last;
  for (double threshold = 20; threshold < 60; ++threshold) {
    const auto transfer = std::make_shared<const TransferFunction>(someTransfer(threshold));
    const FramePlanPtr plan = planner.planFor(scene.step(), transfer, smallView());
    planner.order(plan, {true, {0, 0, 1}}, Arrangement::kWhole);
    EXPECT_TRUE(last.expired());
    last = plan;
  }
}

}  // namespace
}  // namespace sluice

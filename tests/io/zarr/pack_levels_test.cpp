// The coarser levels that packing makes, against NumPy's and against each other.
#include <gmock/gmock.h>

#include <atomic>
#include <limits>

#include "io/zarr/levels/level_region.h"
#include "io/zarr/packing/zarr_writer.h"
#include "io/zarr/reading/zarr_source.h"
#include "tests/io/image_test_support.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

using testing::HasSubstr;

PackReport pack(VolumeSource& source, const std::filesystem::path& output,
                const PackOptions& options, int threads = 2) {
  WorkerPool pool(threads);
  ProgressMeter progress;
  return packZarr(source, output, options, pool, progress);
}

PackOptions withLevels(Downsample how = Downsample::kMean) {
  PackOptions options;
  options.chunk_voxels = 8;
  options.with_levels = true;
  options.downsample = {how};
  options.levels = 2;
  options.replace = true;
  return options;
}

VolumeLayout layoutOf(Vec3i dims, Vec3d spacing = {1, 1, 1}) {
  VolumeLayout layout;
  layout.dims = dims;
  layout.spacing = spacing;
  return layout;
}

std::vector<Vec3i> stepsOf(const VolumeLayout& layout, int64_t chunk,
                           std::optional<int64_t> most = std::nullopt) {
  std::vector<Vec3i> steps;
  for (const LevelShape& level : levelShapes(layout, chunk, most)) steps.push_back(level.step);
  return steps;
}

TEST(LevelShapes, endAt64VoxelsASideOrAtAChunksSide) {
  EXPECT_EQ(stepsOf(layoutOf({64, 64, 64}), 64), std::vector<Vec3i>{});
  EXPECT_EQ(stepsOf(layoutOf({65, 20, 20}), 64), (std::vector<Vec3i>{{2, 2, 2}}));
  EXPECT_EQ(stepsOf(layoutOf({300, 300, 300}), 64),
            (std::vector<Vec3i>{{2, 2, 2}, {4, 4, 4}, {8, 8, 8}}));
  EXPECT_EQ(stepsOf(layoutOf({3000, 300, 300}), 4), (std::vector<Vec3i>{{2, 2, 2}, {4, 4, 4}}));
  EXPECT_EQ(stepsOf(layoutOf({30, 30, 30}), 64, 2), (std::vector<Vec3i>{{2, 2, 2}, {4, 4, 4}}));
  EXPECT_EQ(stepsOf(layoutOf({3, 1, 30}), 64, 3),
            (std::vector<Vec3i>{{2, 1, 2}, {4, 1, 4}, {4, 1, 8}}));
}

TEST(LevelShapes, halveTheAxesWhoseVoxelsAreShort) {
  EXPECT_EQ(stepsOf(layoutOf({256, 256, 64}, {1, 1, 4}), 64, 3),
            (std::vector<Vec3i>{{2, 2, 1}, {4, 4, 1}, {8, 8, 2}}));
  EXPECT_EQ(stepsOf(layoutOf({256, 256, 256}, {1, 1, 1.3}), 64, 1),
            (std::vector<Vec3i>{{2, 2, 2}}));
  EXPECT_EQ(stepsOf(layoutOf({256, 256, 256}, {2, 1, 2}), 64, 2),
            (std::vector<Vec3i>{{1, 2, 1}, {2, 4, 2}}));
}

TEST(PackLevels, areNumPysMeansExtremesAndModes) {
  if (!hasPythonModules("numpy, zarr")) GTEST_SKIP() << "python3 with numpy and zarr is missing";
  const TempFolder folder;
  struct Case {
    Vec3i dims;
    VoxelType type;
    Vec3d spacing{1, 1, 1};
  };
  const std::vector<Case> cases = {{{16, 16, 16}, VoxelType::kU8},
                                   {{33, 17, 9}, VoxelType::kU8},
                                   {{5, 31, 20}, VoxelType::kI16},
                                   {{40, 7, 13}, VoxelType::kU16},
                                   {{19, 23, 29}, VoxelType::kF32},
                                   {{12, 12, 30}, VoxelType::kI8, {4, 4, 1}},
                                   {{21, 30, 8}, VoxelType::kU32, {1, 1, 3}},
                                   {{9, 40, 11}, VoxelType::kI32},
                                   {{18, 10, 26}, VoxelType::kF64, {0.5, 2, 0.5}},
                                   {{1, 25, 37}, VoxelType::kU8}};
  const std::pair<Downsample, const char*> ways[] = {{Downsample::kMean, "mean"},
                                                     {Downsample::kMax, "max"},
                                                     {Downsample::kMin, "min"},
                                                     {Downsample::kMode, "mode"}};
  std::string stores;  // each with its way, for one start of Python
  int count = 0;
  for (const Case& c : cases)
    for (const auto& [how, name] : ways) {
      const auto store = folder / fmt::format("{}.zarr", count++);
      stores += fmt::format(" {} {}", shellQuoted(store.string()), name);
      SCOPED_TRACE(fmt::format("{} x {} x {} {} {}", c.dims.x, c.dims.y, c.dims.z,
                               sluice::name(c.type), name));
      VolumeLayout layout = layoutOf(c.dims, c.spacing);
      layout.type = c.type;
      layout.origin = {10, -20, 30};
      const auto noise = makeWhiteNoise(c.dims, VoxelType::kU8, 5);
      const std::span<const std::byte> bytes = noise->bytes();
      FunctionSource source(layout, [&, how = how](int64_t, Vec3i p) {
        const auto byte =
            static_cast<int>(bytes[static_cast<size_t>((p.z * c.dims.y + p.y) * c.dims.x + p.x)]);
        return how == Downsample::kMode ? byte % 5 : byte - (c.type == VoxelType::kI8 ? 128 : 0);
      });
      const PackReport report = pack(source, store, withLevels(how));
      EXPECT_EQ(report.levels.size(), 2U);
      // Our own reader finds the same.
      ZarrSource packed(store);
      EXPECT_EQ(packed.layout().notes, std::vector<std::string>{});
      const std::vector<LevelShape> shapes = levelShapes(layout, 8, 2);
      ASSERT_EQ(packed.levelsAbove().size(), shapes.size());
      for (size_t i = 0; i < shapes.size(); ++i) {
        EXPECT_EQ(packed.levelsAbove()[i].source->layout().dims, report.levels[i]);
        const VolumeSource* const spreads = packed.levelsAbove()[i].spreads;
        ASSERT_EQ(spreads != nullptr, how == Downsample::kMean || how == Downsample::kMode);
        EXPECT_EQ(packed.levelsAbove()[i].values, valuesOf(how));
        if (spreads != nullptr) {
          EXPECT_EQ(spreads->layout().dims, report.levels[i]);
          EXPECT_EQ(spreads->layout().type, spreadType(c.type));
        }
        const LevelPlacement found = packed.levelsAbove()[i].placement;
        const LevelPlacement expected = placementOf(shapes[i]);
        for (int a = 0; a < 3; ++a) {
          EXPECT_NEAR(found.scale[a], expected.scale[a], 1e-9);
          EXPECT_NEAR(found.offset[a], expected.offset[a], 1e-9);
        }
      }
    }
  const CommandResult compared =
      runCommand("/usr/bin/python3 " SLUICE_TEST_DIR "/check_packed_levels.py" + stores);
  EXPECT_EQ(compared.status, 0) << compared.output;
}

// The levels of the source with others of this kind in a store are `values` ones of equal places.
void expectKind(const ZarrSource& store, LevelValues values) {
  const auto levels = store.levelsAbove(), others = store.levelsOfKind(values);
  ASSERT_EQ(others.size(), levels.size());
  for (size_t i = 0; i < levels.size(); ++i) {
    EXPECT_EQ(others[i].values, values);
    EXPECT_EQ(others[i].placement, levels[i].placement);
    EXPECT_EQ(others[i].spreads, nullptr);
    EXPECT_NE(others[i].source->identity(), levels[i].source->identity());
  }
}

TEST(PackLevels, ofSeveralKindsLieInOneStore) {
  if (!hasPythonModules("numpy, zarr")) GTEST_SKIP() << "python3 with numpy and zarr is missing";
  const TempFolder folder;
  for (const auto& [ways, words] :
       {std::pair<std::vector<Downsample>, const char*>{
            {Downsample::kMean, Downsample::kMax, Downsample::kMin}, "mean,max,min"},
        {{Downsample::kMode, Downsample::kMax}, "mode,max"}}) {
    SCOPED_TRACE(words);
    const auto source = makeSparseBlobs({.dims = {43, 37, 29}, .type = VoxelType::kU16});
    PackOptions options = withLevels();
    options.downsample = ways;
    pack(*source, folder / "v.zarr", options);
    const CommandResult compared =
        runCommand(fmt::format("/usr/bin/python3 " SLUICE_TEST_DIR "/check_packed_levels.py {} {}",
                               shellQuoted((folder / "v.zarr").string()), words));
    EXPECT_EQ(compared.status, 0) << compared.output;
    const ZarrSource packed(folder / "v.zarr");
    EXPECT_EQ(packed.layout().notes, std::vector<std::string>{});
    EXPECT_EQ(packed.levelsAbove().front().values, valuesOf(ways.front()));
    for (size_t i = 1; i < ways.size(); ++i) expectKind(packed, valuesOf(ways[i]));
    EXPECT_TRUE(packed.levelsOfKind(valuesOf(ways.front())).empty());
  }
}

TEST(PackLevels, ofOneKindThatDoNotFitAreLeftOutAndSaid) {
  const TempFolder folder;
  const auto source = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 1);
  PackOptions options = withLevels();
  options.downsample = {Downsample::kMean, Downsample::kMax};
  pack(*source, folder / "v.zarr", options);
  const auto group = folder / "v.zarr/maximum";
  std::filesystem::remove_all(group / "2");
  std::filesystem::copy(group / "1", group / "2", std::filesystem::copy_options::recursive);
  const ZarrSource damaged(folder / "v.zarr");
  EXPECT_THAT(damaged.layout().notes,
              testing::ElementsAre(HasSubstr(
                  "the maximum of level 2 is left out: its shape is not that of the level")));
  EXPECT_EQ(damaged.levelsAbove().size(), 2U);
  EXPECT_EQ(damaged.levelsOfKind(LevelValues::kMaxima).size(), 1U);
}

TEST(PackLevels, doNotDependOnThreadsMemoryOrInterruptions) {
  const TempFolder folder;
  const auto source = makeSparseBlobs({.dims = {70, 50, 45}, .time_steps = 2});
  PackOptions options = withLevels();
  options.levels = 3;
  pack(*source, folder / "a.zarr", options, 1);
  const auto expected = filesOf(folder / "a.zarr");
  options.memory_bytes = 80'000;  // less than a layer of chunks takes
  pack(*source, folder / "b.zarr", options, 3);
  EXPECT_TRUE(filesOf(folder / "b.zarr") == expected);
  options.memory_bytes = uint64_t{256} << 20;
  std::atomic<int64_t> left = 0;  // voxels until a read fails
  FunctionSource stopping(source->layout(), [&](int64_t time, Vec3i p) {
    if (--left == 0) throw Error("stopped");
    const Vec3i d = source->layout().dims;
    const auto at = static_cast<size_t>(((time * d.z + p.z) * d.y + p.y) * d.x + p.x);
    return static_cast<double>(source->bytes()[at]);
  });
  for (const int64_t voxels : {10'000, 60'000, 120'000, 170'000, 300'000}) {
    SCOPED_TRACE(voxels);
    left = voxels;
    EXPECT_THROW(pack(stopping, folder / "c.zarr", options, 1), Error);
    left = 0;
    EXPECT_GT(pack(stopping, folder / "c.zarr", options, 2).kept_chunks, voxels < 28'000 ? -1 : 0);
    EXPECT_TRUE(filesOf(folder / "c.zarr") == expected);
  }
}

TEST(PackLevels, tooLittleMemoryAndTooManyLevelsAreOneLine) {
  const TempFolder folder;
  const auto source = makeSparseBlobs({.dims = {70, 50, 45}});
  PackOptions options = withLevels();
  options.memory_bytes = 30'000;
  EXPECT_THAT(errorOf([&] { pack(*source, folder / "v.zarr", options); }),
              HasSubstr("or more, or --levels none"));
  options = withLevels();
  options.levels = 9;
  EXPECT_THAT(errorOf([&] { pack(*source, folder / "v.zarr", options); }),
              HasSubstr("--levels 9: 70 x 50 x 45 voxels in chunks of 8 have 3 coarser levels"));
}

// Far from 0 the squares of values would cancel each other.
TEST(PackLevels, spreadsOfValuesFarFromZeroAreThoseAroundTheirMean) {
  const TempFolder folder;
  VolumeLayout layout = layoutOf({24, 16, 16});
  for (const VoxelType type : {VoxelType::kF64, VoxelType::kI32}) {
    layout.type = type;
    FunctionSource source(
        layout, [](int64_t, Vec3i p) { return 1e9 + static_cast<double>((p.x + p.y + p.z) % 2); });
    pack(source, folder / "v.zarr", withLevels());
    ZarrSource packed(folder / "v.zarr");
    for (const CoarserLevel& level : packed.levelsAbove()) {
      const Box3 all = boxOf(level.source->layout().dims);
      std::vector<float> spreads(static_cast<size_t>(all.count()));
      level.spreads->readRegion(0, all, std::as_writable_bytes(std::span(spreads)));
      for (const float spread : spreads) ASSERT_NEAR(spread, 1, 1e-5);
    }
  }
}

TEST(PackLevels, whatIsNoNumberHasNoPartInASpread) {
  const TempFolder folder;
  VolumeLayout layout = layoutOf({16, 16, 16});
  layout.type = VoxelType::kF32;
  FunctionSource source(layout, [](int64_t, Vec3i p) {
    if (p.x < 2) return std::numeric_limits<double>::quiet_NaN();
    if (p.x == 4) return std::numeric_limits<double>::infinity();
    return p.x % 2 == 0 ? 3.0 : p.x == 7 ? std::numeric_limits<double>::quiet_NaN() : 5.0;
  });
  pack(source, folder / "v.zarr", withLevels());
  ZarrSource packed(folder / "v.zarr");
  std::vector<float> spreads(8);
  packed.levelsAbove()[0].spreads->readRegion(0, {{0, 0, 0}, {8, 1, 1}},
                                              std::as_writable_bytes(std::span(spreads)));
  EXPECT_EQ(spreads, (std::vector<float>{0, 2, 0, 0, 2, 2, 2, 2}));
}

TEST(PackLevels, spreadsThatDoNotFitAreLeftOutAndSaid) {
  const TempFolder folder;
  const auto source = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 1);
  pack(*source, folder / "v.zarr", withLevels());
  std::filesystem::remove_all(folder / "v.zarr/spread/1");
  std::filesystem::copy(folder / "v.zarr/spread/2", folder / "v.zarr/spread/1",
                        std::filesystem::copy_options::recursive);
  std::filesystem::remove_all(folder / "v.zarr/spread/2");
  const ZarrSource packed(folder / "v.zarr");
  ASSERT_EQ(packed.levelsAbove().size(), 2U);
  for (const CoarserLevel& level : packed.levelsAbove()) EXPECT_EQ(level.spreads, nullptr);
  EXPECT_THAT(
      packed.layout().notes,
      testing::ElementsAre(
          HasSubstr("the spread of level 1 is left out: its shape is not that of the level"),
          HasSubstr("the spread of level 2 is left out: ")));
  // Another pack replaces it all the same.
  EXPECT_GT(pack(*source, folder / "v.zarr", withLevels()).chunks, 0);
}

// Rows of 13, 8 and 5 voxels in chunks of 8 a side: the only voxel lies behind the last whole word.
TEST(PackLevels, keepAVoxelAtTheVeryEndOfAnEmptyRow) {
  const TempFolder folder;
  FunctionSource source(layoutOf({13, 9, 9}), [](int64_t, Vec3i at) {
    return at == Vec3i{12, 8, 8} ? 200.0 : 0.0;
  });
  pack(source, folder / "v.zarr", withLevels());
  ZarrSource packed(folder / "v.zarr");
  uint8_t voxel = 0;
  packed.readRegion(0, {{12, 8, 8}, {13, 9, 9}}, std::as_writable_bytes(std::span(&voxel, 1)));
  EXPECT_EQ(voxel, 200);
  ASSERT_EQ(packed.levelsAbove().size(), 2U);
  packed.levelsAbove()[0].source->readRegion(0, {{6, 4, 4}, {7, 5, 5}},
                                             std::as_writable_bytes(std::span(&voxel, 1)));
  EXPECT_EQ(voxel, 200);  // the only voxel of its block
}

TEST(PackLevels, aDamagedOrMissingChunkOfALevelIsFound) {
  const TempFolder folder;
  const auto source = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 1);
  PackOptions options = withLevels();
  options.downsample.push_back(Downsample::kMax);
  pack(*source, folder / "v.zarr", options);
  WorkerPool pool(2);
  ProgressMeter quiet;
  EXPECT_EQ(checkZarr(folder / "v.zarr", pool, quiet).faults.size(), 0U);
  std::filesystem::remove(folder / "v.zarr/1/0/1/0");
  std::string bytes = readFile(folder / "v.zarr/2/0/0/1");
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  writeFile(folder / "v.zarr/2/0/0/1", bytes);
  std::filesystem::remove(folder / "v.zarr/maximum/1/1/0/0");
  std::filesystem::remove(folder / "v.zarr/spread/1/0/0/1");
  const CheckReport report = checkZarr(folder / "v.zarr", pool, quiet);
  ASSERT_EQ(report.faults.size(), 4U);
  EXPECT_THAT(report.faults[2], HasSubstr("v.zarr/maximum/1/1/0/0"));
  EXPECT_THAT(report.faults[3], HasSubstr("v.zarr/spread/1/0/0/1"));
  EXPECT_THAT(report.faults[0], HasSubstr("v.zarr/1/0/1/0"));
  EXPECT_THAT(report.faults[1], HasSubstr("v.zarr/2/0/0/1"));
}

TEST(LevelRegion, isThatOfTheWholeLevel) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16})
    for (const Vec3d spacing : {Vec3d{1, 1, 1}, Vec3d{1, 2.1, 4}}) {
      const TempFolder folder;
      const auto noise = makeWhiteNoise({45, 37, 83}, type, 7);
      VolumeLayout layout = noise->layout();
      layout.spacing = spacing;
      FunctionSource source(layout, [&](int64_t, Vec3i p) {
        return visitVoxelType(type, [&](auto voxel) {
          noise->readRegion(0, {p, p + Vec3i{1, 1, 1}},
                            std::as_writable_bytes(std::span(&voxel, 1)));
          return static_cast<double>(voxel);
        });
      });
      PackOptions options = withLevels();
      options.levels = 3;
      pack(source, folder / "v.zarr", options);
      ZarrSource packed(folder / "v.zarr");
      const std::vector<LevelShape> shapes = levelShapes(layout, 8, 3);
      for (size_t i = 0; i < shapes.size(); ++i) {
        const Vec3i dims = shapes[i].dims;
        for (const Box3& box : {boxOf(dims), Box3{dims / 3, dims - dims / 4}}) {
          SCOPED_TRACE(fmt::format("{} level {}", name(type), i + 1));
          const auto count = static_cast<size_t>(box.count());
          std::vector<std::byte> means(count * bytesPerVoxel(type));
          std::vector<std::byte> spreads(count * bytesPerVoxel(spreadType(type)));
          std::vector<std::byte> expected_means(means), expected_spreads(spreads);
          makeLevelRegion(source, 0, shapes[i], Downsample::kMean, box, means, spreads);
          packed.levelsAbove()[i].source->readRegion(0, box, expected_means);
          packed.levelsAbove()[i].spreads->readRegion(0, box, expected_spreads);
          EXPECT_EQ(means, expected_means);
          EXPECT_EQ(spreads, expected_spreads);
        }
      }
    }
}

}  // namespace
}  // namespace sluice

#include "io/vdb/vdb_source.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "io/vdb/vdb_header.h"
#include "tests/io/image_test_support.h"
#include "tests/support/vdb_writer.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::vector<double> asDoubles(VolumeSource& source, const Box3& box) {
  const std::vector<std::byte> bytes = readBox(source, box);
  std::vector<double> result;
  visitVoxelType(source.layout().type, [&](auto tag) {
    for (const auto value : valuesOf<decltype(tag)>(bytes))
      result.push_back(static_cast<double>(value));
  });
  return result;
}

std::vector<VdbGridInfo> gridsOf(const std::filesystem::path& path) {
  File file(path);
  return readVdbGrids(file);
}

class VdbTypes : public testing::TestWithParam<std::pair<std::string, VoxelType>> {};

TEST_P(VdbTypes, deliversEachVoxelAsOpenVdbStatesIt) {
  const TempFolder folder;
  const WrittenGrid written = writeMixedGrid(folder / "a.vdb", GetParam().first);
  const auto source = openVdb(folder / "a.vdb");
  EXPECT_EQ(source->layout().type, GetParam().second);
  ASSERT_EQ(source->layout().dims, written.box.size());
  EXPECT_EQ(asDoubles(*source, boxOf(written.box.size())), written.values);
}

TEST_P(VdbTypes, readsAnyBoxAsPartOfTheWhole) {
  const TempFolder folder;
  const WrittenGrid written = writeMixedGrid(folder / "a.vdb", GetParam().first);
  const auto source = openVdb(folder / "a.vdb");
  const Vec3i dims = written.box.size();
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    Box3 box;
    for (int a = 0; a < 3; ++a) {
      box.lo[a] = static_cast<int64_t>(random() % static_cast<uint64_t>(dims[a]));
      box.hi[a] = std::min<int64_t>(dims[a], box.lo[a] + 1 + static_cast<int64_t>(random() % 30));
    }
    const std::vector<double> values = asDoubles(*source, box);
    size_t n = 0;
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (int64_t x = box.lo.x; x < box.hi.x; ++x, ++n)
          ASSERT_EQ(values[n], written.values[static_cast<size_t>((z * dims.y + y) * dims.x + x)])
              << x << " " << y << " " << z;
  }
}

TEST_P(VdbTypes, occupancyCoversAllThatDiffersFromTheBackground) {
  const TempFolder folder;
  const WrittenGrid written = writeMixedGrid(folder / "a.vdb", GetParam().first);
  const auto source = openVdb(folder / "a.vdb");
  const auto occupancy = source->occupancy(0);
  ASSERT_TRUE(occupancy.has_value());
  EXPECT_EQ(static_cast<int64_t>(occupancy->boxes.size()), written.leaves + written.tiles);
  const Vec3i dims = written.box.size();
  std::vector<bool> covered(written.values.size());
  for (const Box3& box : occupancy->boxes) {
    ASSERT_TRUE(!box.empty() && boxOf(dims).contains(box));
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (int64_t x = box.lo.x; x < box.hi.x; ++x)
          covered[static_cast<size_t>((z * dims.y + y) * dims.x + x)] = true;
  }
  int64_t outside = 0;
  for (size_t i = 0; i < covered.size(); ++i) {
    if (covered[i]) continue;
    ++outside;
    ASSERT_EQ(written.values[i], occupancy->background);
  }
  EXPECT_GT(outside, 0);
}

TEST_P(VdbTypes, survivesDamage) {
  const TempFolder folder;
  writeMixedGrid(folder / "a.vdb", GetParam().first);
  const size_t header_end = gridsOf(folder / "a.vdb").at(0).transform_at;
  for (const size_t from : {size_t{0}, header_end, gridsOf(folder / "a.vdb").at(0).values_at}) {
    EXPECT_EQ(surviveDamage(folder / "a.vdb", folder / "bad.vdb", 40, from,
                            [](const auto& path) {
                              const auto source = openVdb(path);
                              const Vec3i dims = source->layout().dims;
                              readBox(*source, boxOf(min(dims, Vec3i{100, 100, 100})));
                            }),
              0);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each, VdbTypes,
    testing::Values(std::pair{"float", VoxelType::kF32}, std::pair{"half", VoxelType::kF32},
                    std::pair{"double", VoxelType::kF64}, std::pair{"int32", VoxelType::kI32},
                    std::pair{"int64", VoxelType::kF64}, std::pair{"bool", VoxelType::kU8},
                    std::pair{"mask", VoxelType::kU8}),
    [](const auto& test) { return test.param.first; });

TEST(VdbSource, addsOneVoxelOfBackgroundOnEachSide) {
  const TempFolder folder;
  writePoints(folder / "a.vdb", {{{10, 20, 30}, 5.0F}});
  const auto source = openVdb(folder / "a.vdb");
  ASSERT_EQ(source->layout().dims, (Vec3i{3, 3, 3}));
  EXPECT_EQ(source->layout().origin, (Vec3d{9, 19, 29}));
  const auto values = valuesOf<float>(readAll(*source));
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], i == 13 ? 5.0F : 0.0F);
}

TEST(VdbSource, readsVoxelsAtTheEndsOfTheIndexSpace) {
  const TempFolder folder;
  constexpr int kLow = -2147483648, kHigh = 2147483647;
  writePoints(folder / "a.vdb",
              {{{kLow, kLow, kLow}, 1.0F}, {{kHigh, kHigh, kHigh}, 2.0F}, {{0, 0, 0}, 3.0F}});
  const auto source = openVdb(folder / "a.vdb");
  const int64_t side = (int64_t{1} << 32) + 2;
  ASSERT_EQ(source->layout().dims, (Vec3i{side, side, side}));
  const int64_t middle = (int64_t{1} << 31) + 1;
  EXPECT_EQ(valueAt<float>(*source, {0, 0, 0}), 0.0F);  // the padding, beyond OpenVDB's coordinates
  EXPECT_EQ(valueAt<float>(*source, {1, 1, 1}), 1.0F);
  EXPECT_EQ(valueAt<float>(*source, {middle, middle, middle}), 3.0F);
  EXPECT_EQ(valueAt<float>(*source, {side - 2, side - 2, side - 2}), 2.0F);
  EXPECT_EQ(valueAt<float>(*source, {side - 1, side - 1, side - 1}), 0.0F);
  EXPECT_EQ(valueAt<float>(*source, {middle, 1, 1}), 0.0F);
  // A long row crosses a million empty nodes.
  const auto row =
      valuesOf<float>(readBox(*source, {{middle - 9'000'000, middle, middle},
                                        {middle + 9'000'000, middle + 1, middle + 1}}));
  EXPECT_EQ(row[9'000'000], 3.0F);
  EXPECT_EQ(std::count(row.begin(), row.end(), 0.0F), 17'999'999);
  const auto occupancy = source->occupancy(0);
  EXPECT_EQ(occupancy->boxes.size(), 3U);
  EXPECT_LT(source->storedBytesRead(), uint64_t{16} << 20);
}

TEST(VdbSource, honoursRotationAndOrigin) {
  const TempFolder folder;
  // x steps along world +y by 2, y along world -x by 3, z along world +z by 4.
  writeTransformed(folder / "a.vdb", {{0, 2, 0}, {-3, 0, 0}, {0, 0, 4}, {100, 200, 300}});
  const auto source = openVdb(folder / "a.vdb");
  const VolumeLayout& layout = source->layout();
  EXPECT_EQ(layout.spacing, (Vec3d{2, 3, 4}));
  EXPECT_EQ(layout.axes[0], (Vec3d{0, 1, 0}));
  EXPECT_EQ(layout.axes[1], (Vec3d{-1, 0, 0}));
  EXPECT_EQ(layout.axes[2], (Vec3d{0, 0, 1}));
  // Voxel (0, 0, 0) is index (2, 3, 4): world (100 - 9, 200 + 4, 300 + 16).
  EXPECT_EQ(layout.origin, (Vec3d{91, 204, 316}));
}

TEST(VdbSource, rejectsTransformsThatAreNotAffine) {
  const TempFolder folder;
  writeFrustum(folder / "a.vdb");
  EXPECT_THAT(errorOf([&] { openVdb(folder / "a.vdb"); }), HasSubstr("expected an affine one"));
}

TEST(VdbSource, choosesTheFirstGridOfFloats) {
  const TempFolder folder;
  writeSeveral(folder / "a.vdb");
  const auto first = openVdb(folder / "a.vdb");
  EXPECT_EQ(valueAt<float>(*first, {1, 1, 1}), 2.0F);
  const auto second = openVdb(folder / "a.vdb", "density[1]");
  EXPECT_EQ(valueAt<double>(*second, {1, 1, 1}), 3.0);
  const auto id = openVdb(folder / "a.vdb", "id");
  EXPECT_EQ(valueAt<int32_t>(*id, {1, 1, 1}), 7);
  EXPECT_NE(first->identity(), id->identity());
}

TEST(VdbSource, namesTheGridsWhenOneIsMissing) {
  const TempFolder folder;
  writeSeveral(folder / "a.vdb");
  EXPECT_THAT(
      errorOf([&] { openVdb(folder / "a.vdb", "heat"); }),
      AllOf(HasSubstr("no grid \"heat\""), HasSubstr("velocity (vec3s"), HasSubstr("id (int32"),
            HasSubstr("density[0] (float, fog volume)"), HasSubstr("density[1] (double")));
  EXPECT_THAT(errorOf([&] { openVdb(folder / "a.vdb", "velocity"); }), HasSubstr("holds vec3s"));
}

TEST(VdbSource, rejectsAGridWithoutActiveVoxels) {
  const TempFolder folder;
  writeSeveral(folder / "a.vdb");
  EXPECT_THAT(errorOf([&] { openVdb(folder / "a.vdb", "nothing"); }),
              HasSubstr("no active voxels"));
}

TEST(VdbSource, leavesAreReadWhenAskedForAndNotKept) {
  const TempFolder folder;
  const WrittenGrid written = writeMixedGrid(folder / "a.vdb", "float");
  const auto grid = gridsOf(folder / "a.vdb").at(0);
  const uint64_t value_bytes = grid.end - grid.values_at;
  const auto source = openVdb(folder / "a.vdb");
  const uint64_t opened = source->storedBytesRead();
  readAll(*source);
  EXPECT_EQ(source->storedBytesRead() - opened, value_bytes);
  readAll(*source);  // decoded again: the tree kept nothing
  EXPECT_EQ(source->storedBytesRead() - opened, 2 * value_bytes);
}

// A read never mixes old and new voxels and never raises a signal, as for raw files.
TEST(VdbSource, aFileThatIsCutOrOverwrittenMeanwhileIsAnError) {
  for (const char* type : {"float", "half"}) {
    const TempFolder folder;
    writeMixedGrid(folder / "a.vdb", type);
    const std::string bytes = readFile(folder / "a.vdb");
    const auto source = openVdb(folder / "a.vdb");
    std::filesystem::resize_file(folder / "a.vdb", 4096);
    EXPECT_THAT(errorOf([&] { readAll(*source); }),
                testing::AnyOf(HasSubstr("changed while it was open"), HasSubstr("short read")));
    writeFile(folder / "a.vdb", bytes);
    const auto again = openVdb(folder / "a.vdb");
    readAll(*again);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // another time of change
    std::fstream(folder / "a.vdb", std::ios::in | std::ios::out).write("overwritten", 11);
    EXPECT_THAT(errorOf([&] { readAll(*again); }), HasSubstr("changed while it was open"));
  }
}

TEST(VdbSource, saysWhichGridOfSeveralIsReadAndWhatElseThereIs) {
  const TempFolder folder;
  writeSeveral(folder / "a.vdb");
  const auto source = openVdb(folder / "a.vdb");
  EXPECT_THAT(source->layout().grids,
              testing::ElementsAre("velocity", "id", "density[0]", "density[1]", "nothing"));
  ASSERT_EQ(source->layout().notes.size(), 1U);
  EXPECT_THAT(source->layout().notes[0],
              AllOf(HasSubstr("grid density[0] of 5"), HasSubstr("id (int32)")));
  EXPECT_THAT(openVdb(folder / "a.vdb", "id")->layout().notes, testing::IsEmpty());
  writePoints(folder / "b.vdb", {{{1, 2, 3}, 5.0F}});
  EXPECT_THAT(openVdb(folder / "b.vdb")->layout().notes, testing::IsEmpty());
}

TEST(VdbSource, threadsReadAtOnce) {
  const TempFolder folder;
  const WrittenGrid written = writeMixedGrid(folder / "a.vdb", "float");
  const auto source = openVdb(folder / "a.vdb");
  const auto whole = readAll(*openVdb(folder / "a.vdb"));
  std::array<std::vector<std::byte>, 4> read;
  std::vector<std::thread> threads;
  for (auto& mine : read) threads.emplace_back([&] { mine = readAll(*source); });
  for (auto& thread : threads) thread.join();
  for (const auto& mine : read) EXPECT_TRUE(mine == whole);
}

TEST(VdbSource, rejectsTruncatedFile) {
  const TempFolder folder;
  writeMixedGrid(folder / "a.vdb", "float");
  const std::string bytes = readFile(folder / "a.vdb");
  for (size_t keep = 0; keep < bytes.size(); keep += keep < 600 ? 7 : 997) {
    writeFile(folder / "cut.vdb", std::string_view(bytes).substr(0, keep));
    EXPECT_NE(errorOf([&] { openVdb(folder / "cut.vdb"); }), "") << keep;
  }
  writeFile(folder / "cut.vdb", std::string_view(bytes).substr(0, bytes.size() - 1));
  EXPECT_NE(errorOf([&] { openVdb(folder / "cut.vdb"); }), "");
}

// Compression off, zip and blosc lay a node's values out in ways of their own.
TEST(VdbSource, readsAndChecksEachCompression) {
  const TempFolder folder;
  for (const uint32_t flags : {0U, 1U, 2U, 3U, 4U, 6U}) {
    SCOPED_TRACE(flags);
    const WrittenGrid written = writeMixedGrid(folder / "a.vdb", "half", flags);
    const auto source = openVdb(folder / "a.vdb");
    EXPECT_EQ(gridsOf(folder / "a.vdb").at(0).compression, flags);
    EXPECT_EQ(asDoubles(*source, boxOf(written.box.size())), written.values);
    surviveDamage(folder / "a.vdb", folder / "bad.vdb", 40, 0, [](const auto& path) {
      const auto damaged = openVdb(path);
      readBox(*damaged, boxOf(min(damaged->layout().dims, Vec3i{100, 100, 100})));
    });
  }
}

TEST(VdbSource, survivesDamagedHeader) {
  const TempFolder folder;
  writeSeveral(folder / "a.vdb");
  const std::string bytes = readFile(folder / "a.vdb");
  std::mt19937 random(2);
  int failures = 0;
  for (int i = 0; i < 400; ++i) {
    std::string changed = bytes;
    changed[random() % 300] = static_cast<char>(random() & 0xffU);
    writeFile(folder / "bad.vdb", changed);
    try {
      describe(gridsOf(folder / "bad.vdb"));
    } catch (const Error&) {
      ++failures;
    }
  }
  EXPECT_GT(failures, 20);
}

// Replaces the first text after `key` in the file by one of the same length.
void replaceAfter(const std::filesystem::path& path, const std::string& key, const std::string& old,
                  const std::string& text) {
  std::string bytes = readFile(path);
  const size_t at = bytes.find(old, bytes.find(key) + key.size());
  ASSERT_NE(at, std::string::npos);
  writeFile(path, bytes.replace(at, old.size(), text));
}

TEST(VdbSource, metadataOfWrongTypesAreNamed) {
  const TempFolder folder;
  for (const auto& [key, type, wrong] :
       std::vector<std::array<std::string, 3>>{{"class", "string", "strong"},
                                               {"is_saved_as_half_float", "bool", "pool"},
                                               {"file_bbox_min", "vec3i", "vec3s"},
                                               {"file_bbox_max", "vec3i", "vec3s"}}) {
    if (key == "class")
      writeSeveral(folder / "a.vdb");
    else
      writeMixedGrid(folder / "a.vdb", "half");
    replaceAfter(folder / "a.vdb", key, type, wrong);
    EXPECT_THAT(errorOf([&] { openVdb(folder / "a.vdb"); }),
                AllOf(HasSubstr("a.vdb"), HasSubstr("metadatum \"" + key + "\" has the type \"" +
                                                    wrong + "\", expected " + type)));
  }
}

TEST(VdbSource, aClassOfNoMeaningIsNamed) {
  const TempFolder folder;
  writeSeveral(folder / "a.vdb");
  EXPECT_THAT(openVdb(folder / "a.vdb", "density[0]")->layout().notes, testing::IsEmpty());
  replaceAfter(folder / "a.vdb", "class", "fog volume", "smog balls");
  EXPECT_THAT(openVdb(folder / "a.vdb", "density[0]")->layout().notes,
              testing::ElementsAre(HasSubstr("of the class \"smog balls\", which is none of")));
}

}  // namespace
}  // namespace sluice

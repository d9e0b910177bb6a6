#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "io/open_volume.h"
#include "io/stores/folder_store.h"
#include "io/zarr/n5/n5_attributes.h"
#include "io/zarr/n5/n5_volume.h"
#include "io/zarr/reading/chunked_source.h"
#include "tests/io/python_volumes.h"
#include "tests/io/zarr/map_store.h"
#include "tests/io/zarr/zarr_case.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

struct N5Case : ZarrCase {
  static constexpr const char* kScript = "make_n5.py";
};

class N5 : public PythonVolumesTest<N5Case> {
 protected:
  static fs::path copyOf(const TempFolder& folder, const std::string& name) {
    fs::copy(pathOf(name), folder / name, fs::copy_options::recursive);
    return folder / name;
  }
  static std::string readError(const fs::path& folder) {
    return errorOf([&] {
      ChunkedSource source(n5Volume(folderPlace(folder)));
      allSteps(source);
    });
  }
  // As if it had been so when the volume was opened.
  static void write(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(1));
  }
};

TEST_F(N5, dataSetsAreReadAsTheyWereWritten) {
  ASSERT_GT(cases_.size(), 35U);
  int sparse = 0;
  for (const N5Case& c : cases_) {
    SCOPED_TRACE(c.name);
    ChunkedOptions options = c.options();
    options.chunk_cache_bytes = 1;
    ChunkedSource source(n5Volume(folderPlace(pathOf(c.name))), options);
    EXPECT_EQ(source.layout().dims, c.dims);
    EXPECT_EQ(name(source.layout().type), c.type);
    EXPECT_EQ(source.layout().time_steps, c.steps);
    EXPECT_EQ(source.occupancy(0).has_value(), c.missing);
    sparse += c.missing ? 1 : 0;
    const std::string whole = voxelsOf(c.name);
    EXPECT_TRUE(allSteps(source) == whole);
    expectBoxesAreParts(source, whole);
  }
  EXPECT_EQ(sparse, 2);
}

TEST_F(N5, aStoreThatCannotBeListedServesToo) {
  for (const std::string name : {"cut_uint16", "left_out", "scales"}) {
    SCOPED_TRACE(name);
    ChunkedSource source(n5Volume({std::make_shared<MapStore>(pathOf(name)), ""}));
    EXPECT_TRUE(asText(readAll(source)) == voxelsOf(name));
  }
}

TEST_F(N5, levelsHaveTheirPlacesInEveryConvention) {
  for (const std::string name :
       {"own_factors", "scales", "group_factors", "transforms", "no_group", "no_factors"}) {
    SCOPED_TRACE(name);
    const auto source = openVolume(pathOf(name).string());
    EXPECT_EQ(source->layout().spacing, (Vec3d{0.5, 0.5, 2}));
    EXPECT_EQ(source->layout().origin, (Vec3d{0, 0, 0}));
    EXPECT_EQ(source->layout().unit, "micrometer");
    EXPECT_EQ(source->layout().notes.size(), name == "no_factors" ? 1U : 0U);
    const std::span<const CoarserLevel> levels = coarserLevels(*source);
    ASSERT_EQ(levels.size(), 2U);
    EXPECT_EQ(levels[0].placement, (LevelPlacement{{2, 2, 1}, {0.5, 0.5, 0}}));
    EXPECT_EQ(levels[1].placement, (LevelPlacement{{4, 4, 2}, {1.5, 1.5, 0.5}}));
    for (int i = 0; i < 2; ++i)
      EXPECT_TRUE(asText(readAll(*levels[static_cast<size_t>(i)].source)) ==
                  readFile(pathOf(name + "_" + std::to_string(i + 1) + ".bin")));
  }
}

TEST_F(N5, aLevelByItselfHasItsPlace) {
  const auto level = openVolume(pathOf("scales/s2").string());
  EXPECT_EQ(level->layout().spacing, (Vec3d{2, 2, 4}));
  EXPECT_EQ(level->layout().origin, (Vec3d{0.75, 0.75, 1}));
  EXPECT_EQ(coarserLevels(*level).size(), 0U);
}

TEST_F(N5, axesAreFoundByTheirNames) {
  const auto source = openVolume(pathOf("channels_1").string(), {.channel = 1});
  EXPECT_EQ(source->layout().channels, 2);
  EXPECT_EQ(source->layout().spacing, (Vec3d{0.5, 0.25, 2}));
}

TEST_F(N5, damagedBlocksAreNamed) {
  struct Damage {
    std::string set;
    std::function<void(std::string&)> change;
    std::string said;
  };
  const auto set = [](size_t at, char value) {
    return [at, value](std::string& block) { block[at] = value; };
  };
  const Damage damages[] = {
      {"raw_0", set(1, 2), "mode 0 or 1, found 2"},
      {"raw_0", set(3, 2), "a block of 3 axes, found 2"},
      {"raw_0", set(7, 7), "a block of 6 to 6 voxels along axis 0, found 7"},
      {"raw_0", set(4, 7), "a block of 6 to 6 voxels along axis 0"},
      {"raw_1", set(19, 1), "as its extents are, found"},
      {"raw_0", [](std::string& block) { block.pop_back(); }, "after the block's header, found"},
      {"raw_0", [](std::string& block) { block.resize(15); }, "cut short"},
      {"raw_0", [](std::string& block) { block.clear(); }, "cut short"},
      {"raw_0", [](std::string& block) { block += std::string(9000, 'a'); }, "at most"},
      {"gzip_0", [](std::string& block) { block.resize(block.size() / 2); }, "cut or damaged"},
      {"zstd_0", [](std::string& block) { block.resize(block.size() / 2); }, "zstd"},
      {"xz_0", [](std::string& block) { block[40] ^= 1; }, "bytes of xz, found damaged"},
      {"blosc_0", [](std::string& block) { block.resize(block.size() / 2); }, "Blosc"}};
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.set + damage.said);
    const TempFolder folder;
    const fs::path file = copyOf(folder, damage.set) / "0/0/0";
    std::string block = readFile(file);
    damage.change(block);
    write(file, block);
    EXPECT_THAT(readError(folder / damage.set),
                AllOf(HasSubstr("0/0/0: "), HasSubstr(damage.said)));
  }
}

TEST_F(N5, aFolderOfNeitherNamesWhatItHolds) {
  EXPECT_THAT(errorOf([] { openVolume(pathOf("scales").parent_path().string()); }),
              testing::Not(HasSubstr("N5")));
  const TempFolder folder;
  write(folder / "attributes.json", R"({"n5": "2.5.0"})");
  EXPECT_THAT(errorOf([&] { openVolume(folder.path().string()); }),
              HasSubstr("an N5 group of neither"));
  copyOf(folder, "scales");
  EXPECT_THAT(errorOf([&] { openVolume(folder.path().string()); }),
              HasSubstr("such as " + (folder / "scales").string()));
}

// The samples of others are of two axes.
TEST(N5Others, volumesHaveThreeAxes) {
  const fs::path data = fs::path(SLUICE_DATA_DIR) / "formats/n5";
  if (!fs::exists(data)) GTEST_SKIP() << data << " is missing";
  for (const std::string name : {"n5_viewer_multiscale_modern", "n5_viewer_multiscale_deprecated"})
    EXPECT_THAT(errorOf([&] { openVolume((data / name).string()); }),
                HasSubstr("expected an array of 3 to 5 axes, found 2"));
}

TEST(N5Attributes, eachMemberIsCheckedByName) {
  const std::string sound =
      R"("dimensions": [7, 6, 5], "blockSize": [4, 3, 2], "dataType": "uint16")";
  const ZarrArray array =
      parseN5Array("{" + sound + R"(, "compression": {"type": "gzip"}})", "v/attributes.json");
  EXPECT_THAT(array.shape, ElementsAre(5, 6, 7));
  EXPECT_THAT(array.chunks, ElementsAre(2, 3, 4));
  EXPECT_EQ(array.fileName(array.fileNumber(std::vector<int64_t>{2, 1, 0})), "0/1/2");
  EXPECT_EQ(parseN5Array("{" + sound + R"(, "compressionType": "raw"})", "").codec,
            ZarrCodec::kNone);
  const std::pair<std::string, std::string> wrong[] = {
      {R"({"blockSize": [1], "dataType": "uint8"})", "/dimensions"},
      {R"({"dimensions": [7, 0], "blockSize": [1, 1], "dataType": "uint8"})", "/dimensions/1"},
      {R"({"dimensions": [7, 6], "blockSize": [1], "dataType": "uint8"})",
       "2 extents, as in shape"},
      {R"({"dimensions": [7], "blockSize": [1], "dataType": "uint64"})", "/dataType"},
      {R"({"dimensions": [9], "blockSize": [9000000000], "dataType": "uint8"})", "voxels a chunk"},
      {"{" + sound + "}", "/compressionType"},
      {"{" + sound + R"(, "compression": {"type": "lz4"}})", "as others are not read"},
      {"[]", "an object"}};
  for (const auto& [text, said] : wrong)
    EXPECT_THAT(errorOf([&, text = text] { parseN5Array(text, "v/attributes.json"); }),
                AllOf(HasSubstr("v/attributes.json: "), HasSubstr(said)));
  for (const std::string text :
       {R"({"scales": [[1, "a"]]})", R"({"scales": 1})", R"({"downsamplingFactors": []})",
        R"({"axes": [1]})", R"({"resolution": {}})", R"({"units": [1]})"})
    EXPECT_THAT(errorOf([&] { parseN5Place(text, "v/attributes.json"); }),
                HasSubstr("v/attributes.json: expected"))
        << text;
  EXPECT_THAT(errorOf([] { n5Image(parseN5Place(R"({"scales": [[1], [2]]})", ""), {{}}, 3, "v"); }),
              HasSubstr("v: expected a resolution and factors of 3 numbers"));
}

}  // namespace
}  // namespace sluice

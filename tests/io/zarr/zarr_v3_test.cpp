#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "io/open_volume.h"
#include "io/zarr/reading/crc32c.h"
#include "tests/io/python_volumes.h"
#include "tests/io/zarr/zarr_case.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

struct Zarr3Case : ZarrCase {
  static constexpr const char* kScript = "make_zarr3.py";
  static constexpr const char* kModules = "numpy, numcodecs";
};

class Zarr3 : public PythonVolumesTest<Zarr3Case> {
 protected:
  // A copy of a store, to be damaged.
  static fs::path copyOf(const TempFolder& folder, const std::string& name) {
    fs::copy(pathOf(name), folder / name, fs::copy_options::recursive);
    return folder / name;
  }
  static std::string readError(const fs::path& store) {
    return errorOf([&] {
      ZarrSource source(store);
      allSteps(source);
    });
  }
};

TEST_F(Zarr3, storesAreReadAsTheyWereWritten) {
  ASSERT_GT(cases_.size(), 70U);
  for (const Zarr3Case& c : cases_) {
    SCOPED_TRACE(c.name);
    ZarrSource source(pathOf(c.name), c.options());
    EXPECT_EQ(source.layout().dims, c.dims);
    EXPECT_EQ(name(source.layout().type), c.type);
    EXPECT_EQ(source.layout().time_steps, c.steps);
    EXPECT_EQ(source.occupancy(0).has_value(), c.missing);
    const std::string whole = voxelsOf(c.name);
    EXPECT_TRUE(allSteps(source) == whole);
    expectBoxesAreParts(source, whole);
  }
}

TEST_F(Zarr3, anImageHasItsLevelsPlaceAndUnit) {
  const auto source = openVolume(pathOf("image").string());
  EXPECT_EQ(source->layout().spacing, (Vec3d{1, 1, 3}));
  EXPECT_EQ(source->layout().unit, "micrometer");
  EXPECT_EQ(source->layout().notes.size(), 0U);
  const std::span<const CoarserLevel> levels = coarserLevels(*source);
  ASSERT_EQ(levels.size(), 1U);
  EXPECT_EQ(levels[0].placement.scale, (Vec3d{2, 2, 2}));
  EXPECT_EQ(levels[0].placement.offset, (Vec3d{0.5, 0.5, 0.5}));
  EXPECT_TRUE(asText(readAll(*levels[0].source)) == readFile(pathOf("image_coarse.bin")));
}

// A level by itself has its scale from the image two folders above.
TEST_F(Zarr3, aLevelByItselfHasItsScale) {
  const auto source = openVolume(pathOf("image/scale1/image").string());
  EXPECT_EQ(source->layout().spacing, (Vec3d{2, 2, 6}));
  EXPECT_EQ(source->layout().origin, (Vec3d{0.5, 0.5, 1.5}));
}

// The index is read once, and then only the chunks that the box needs.
TEST_F(Zarr3, aBoxOfAShardReadsTheIndexAndItsChunksAlone) {
  ZarrSource source(pathOf("one_shard"));
  const uint64_t header = source.storedBytesRead();
  readBox(source, {{0, 0, 0}, {5, 4, 2}}, 0);
  const uint64_t shard = fs::file_size(pathOf("one_shard") / "c/0/0/0");
  const uint64_t index = 8 * 4 * 4 * 16 + 4;
  const uint64_t first = source.storedBytesRead() - header;
  EXPECT_GT(first, index);
  EXPECT_LT(first, index + (shard - index) / 20);
  readBox(source, {{5, 0, 0}, {10, 4, 2}}, 0);
  EXPECT_LT(source.storedBytesRead() - header - first, (shard - index) / 20);
}

TEST_F(Zarr3, damagedShardsAreNamed) {
  struct Damage {
    std::string store;
    int64_t from_end;  // the byte that is flipped
    std::string said;
  };
  for (const Damage& damage : {Damage{"index_end_True_little", 4 + 16, "the index of the shard"},
                               {"index_end_True_little", 4 + 16 * 12 + 1, "a chunk is damaged"},
                               {"index_end_False_little", 1, "cut short"},
                               {"crc", 20, "a chunk is damaged"}}) {
    SCOPED_TRACE(damage.store + damage.said);
    const TempFolder folder;
    const fs::path store = copyOf(folder, damage.store), file = store / "c/0/0/0";
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekg(-damage.from_end, std::ios::end);
    const int byte = stream.get();
    stream.seekp(-damage.from_end, std::ios::end);
    stream.put(static_cast<char>(byte ^ 64));
    stream.close();
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(1));
    EXPECT_THAT(readError(store), AllOf(HasSubstr("c/0/0/0: "), HasSubstr(damage.said)));
  }
}

TEST_F(Zarr3, aShardThatIsCutIsNamedAtAnyLength) {
  const TempFolder folder;
  const fs::path store = copyOf(folder, "index_start_True_little"), file = store / "c/0/0/0";
  for (const uint64_t bytes : {fs::file_size(file) - 1, uint64_t{500}, uint64_t{10}, uint64_t{0}}) {
    fs::resize_file(file, bytes);
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(1));
    EXPECT_THAT(readError(store), HasSubstr("c/0/0/0: ")) << bytes;
  }
}

// Arrays of one name that zarrita wrote as version 3 and zarr-python as version 2.
TEST(Zarr3Others, readTheSameVoxelsAsVersion2) {
  const fs::path data = fs::path(SLUICE_DATA_DIR) / "formats/zarr";
  if (!fs::exists(data)) GTEST_SKIP() << data << " is missing";
  const auto voxels = [&](const std::string& folder, const std::string& array) {
    ZarrSource source(data / folder / "data.zarr" / array);
    return asText(readAll(source));
  };
  for (const std::string array :
       {"3d.chunked.i2", "3d.chunked.mixed.i2.C", "3d.chunked.mixed.i2.F", "3d.contiguous.i2"}) {
    const std::string expected = voxels("zarr_v2/from_zarr-python", array);
    EXPECT_EQ(expected.size(), 3U * 3 * 3 * 2);
    EXPECT_TRUE(voxels("zarr_v3/from_zarrita", array) == expected) << array;
  }
  const std::string cube = voxels("zarr_v2/from_zarr-python", "3d.contiguous.i2");
  for (const std::string array :
       {"3d.contiguous.compressed.sharded.i2", "3d.chunked.mixed.compressed.sharded.i2"})
    EXPECT_TRUE(voxels("zarr_v3/from_zarrita", array) == cube) << array;
  ZarrSource sharded(data / "zarr_v3/from_zarrita/data.zarr/3d.chunked.compressed.sharded.i2");
  std::vector<int16_t> values(64);
  const std::vector<std::byte> bytes = readAll(sharded);
  ASSERT_EQ(bytes.size(), values.size() * sizeof(int16_t));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], static_cast<int16_t>(i));
}

// OME-Zarr 0.6, with its chunk in the place of a link to it: transformations that are scalings and
// shifts are read, others refused in one line.
TEST(Zarr3Others, imagesOfVersion06) {
  const fs::path data = fs::path(SLUICE_DATA_DIR) / "formats/zarr/ome_zarr/all_0.6";
  if (!fs::exists(data)) GTEST_SKIP() << data << " is missing";
  const TempFolder folder;
  struct Image {
    std::string name;
    Vec3d spacing, origin;
  };
  for (const Image& image : {Image{"basic/identity", {1, 1, 1}, {0, 0, 0}},
                             {"basic/scale", {2, 3, 4}, {0, 0, 0}},
                             {"basic/translation", {1, 1, 1}, {10, 20, 30}},
                             {"basic/sequenceScaleTranslation", {2, 3, 4}, {10, 21, 32}}}) {
    SCOPED_TRACE(image.name);
    const fs::path store = folder / fs::path(image.name).filename().string();
    fs::copy(data / (image.name + ".zarr"), store, fs::copy_options::recursive);
    fs::copy_file(data / "base_array/0", store / "array/c/0/0/0",
                  fs::copy_options::overwrite_existing);
    const auto source = openVolume(store.string());
    EXPECT_EQ(source->layout().dims, (Vec3i{186, 226, 27}));
    EXPECT_EQ(source->layout().spacing, image.spacing);
    EXPECT_EQ(source->layout().origin, image.origin);
    EXPECT_EQ(source->layout().unit, "micrometer");
    const std::vector<std::byte> voxels = readAll(*source);
    EXPECT_GT(std::count(voxels.begin(), voxels.end(), std::byte{0}), 1000);
    EXPECT_GT(
        std::count_if(voxels.begin(), voxels.end(), [](std::byte b) { return b > std::byte{50}; }),
        1000);
  }
  for (const char* name : {"simple/rotation", "simple/affine", "axis_dependent/mapAxis"})
    EXPECT_THAT(errorOf([&] { openVolume((data / name).string() + ".zarr"); }),
                HasSubstr("expected scale, translation, identity or a sequence of these"));
}

// RFC 3720, appendix B.4.
TEST(Crc32c, isThatOfTheStandard) {
  const auto of = [](const std::string& text) { return crc32c(std::as_bytes(std::span(text))); };
  EXPECT_EQ(of(""), 0U);
  EXPECT_EQ(of("123456789"), 0xe3069283U);
  EXPECT_EQ(of(std::string(32, '\0')), 0x8a9136aaU);
  EXPECT_EQ(of(std::string(32, '\xff')), 0x62a8ab43U);
}

}  // namespace
}  // namespace sluice

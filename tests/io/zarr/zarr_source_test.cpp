#include "io/zarr/reading/zarr_source.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <thread>

#include "io/open_volume.h"
#include "tests/io/python_volumes.h"
#include "tests/io/zarr/zarr_case.h"

namespace sluice::zarr_source_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

using ZarrPython = PythonVolumesTest<ZarrCase>;

TEST_F(ZarrPython, storesAreReadAsTheyWereWritten) {
  ASSERT_GT(cases_.size(), 80U);
  for (const ZarrCase& c : cases_) {
    SCOPED_TRACE(c.name);
    ZarrSource source(pathOf(c.name), c.options());
    EXPECT_EQ(source.layout().dims, c.dims);
    EXPECT_EQ(name(source.layout().type), c.type);
    EXPECT_EQ(source.layout().time_steps, c.steps);
    EXPECT_TRUE(allSteps(source) == voxelsOf(c.name));
  }
}

TEST_F(ZarrPython, boxesInAnyOrderAreParts) {
  for (const ZarrCase& c : cases_) {
    SCOPED_TRACE(c.name);
    ZarrOptions options = c.options();
    options.chunk_cache_bytes = 1;
    ZarrSource source(pathOf(c.name), options);
    expectBoxesAreParts(source, voxelsOf(c.name));
  }
}

// The boxes cover every voxel that is not the fill value, and leave something out.
TEST_F(ZarrPython, missingChunksAreKnownWithoutReading) {
  int sparse = 0;
  for (const ZarrCase& c : cases_) {
    SCOPED_TRACE(c.name);
    ZarrSource source(pathOf(c.name), c.options());
    const auto header_bytes = source.storedBytesRead();
    const auto occupancy = source.occupancy(c.steps - 1);
    EXPECT_EQ(source.storedBytesRead(), header_bytes);
    ASSERT_EQ(occupancy.has_value(), c.missing);
    if (!occupancy) continue;
    ++sparse;
    const auto voxels = readAll(source, c.steps - 1);
    int64_t outside = 0;
    visitVoxelType(source.layout().type, [&](auto tag) {
      const auto values = valuesOf<decltype(tag)>(voxels);
      size_t i = 0;
      for (int64_t z = 0; z < c.dims.z; ++z)
        for (int64_t y = 0; y < c.dims.y; ++y)
          for (int64_t x = 0; x < c.dims.x; ++x, ++i) {
            if (std::any_of(occupancy->boxes.begin(), occupancy->boxes.end(), [&](const Box3& box) {
                  return box.contains(Vec3i{x, y, z});
                }))
              continue;
            ++outside;
            const auto value = static_cast<double>(values[i]);
            // A fill value that is no number is one that nothing equals.
            ASSERT_TRUE(value == occupancy->background ||
                        (std::isnan(value) && std::isnan(occupancy->background)))
                << value << " " << occupancy->background;
          }
    });
    EXPECT_GT(outside, 0);
  }
  EXPECT_GE(sparse, 7);
}

// A second observer: the sizes of the files themselves.
TEST_F(ZarrPython, bytesReadAreThoseOfTheFiles) {
  for (const char* name : {"zstd-dot", "blosc-lz4-1-slash", "none-dot", "chunk-odd"}) {
    SCOPED_TRACE(name);
    uint64_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(pathOf(name)))
      if (entry.is_regular_file()) bytes += entry.file_size();
    ZarrSource source(pathOf(name));
    allSteps(source);
    allSteps(source);  // from the kept chunks
    EXPECT_EQ(source.storedBytesRead(), bytes);
  }
}

TEST_F(ZarrPython, threadsReadAtOnceAndDecodeEachChunkOnce) {
  ZarrSource source(pathOf("blosc-zstd-1-slash"));
  const uint64_t before = source.storedBytesRead();
  std::vector<std::string> results(8);
  {
    std::vector<std::jthread> threads;
    for (std::string& result : results) threads.emplace_back([&] { result = allSteps(source); });
  }
  for (const std::string& result : results) EXPECT_TRUE(result == voxelsOf("blosc-zstd-1-slash"));
  ZarrSource alone(pathOf("blosc-zstd-1-slash"));
  const uint64_t alone_before = alone.storedBytesRead();
  allSteps(alone);
  EXPECT_EQ(source.storedBytesRead() - before, alone.storedBytesRead() - alone_before);
}

TEST_F(ZarrPython, heldBytesStayWithinTheBudget) {
  constexpr uint64_t kChunk = 8 * 8 * 8 * 2;
  for (const uint64_t chunks : {1, 4, 9}) {
    ZarrSource source(pathOf("zlib-dot"), {.chunk_cache_bytes = chunks * kChunk});
    allSteps(source);
    EXPECT_LE(source.heldBytes(), chunks * kChunk);
    EXPECT_GE(source.heldBytes(), std::max<uint64_t>(chunks - 1, 1) * kChunk);
    EXPECT_LE(source.peakHeldBytes(), std::max<uint64_t>(chunks, 2) * kChunk);
  }
}

TEST_F(ZarrPython, aLevelIsReadByItsOwnFolder) {
  ZarrSource whole(pathOf("ome-3d")), level(pathOf("ome-3d") / "0");
  EXPECT_EQ(whole.layout().spacing, (Vec3d{0.25, 0.5, 2}));
  EXPECT_EQ(level.layout().spacing, whole.layout().spacing);
  EXPECT_TRUE(allSteps(level) == voxelsOf("ome-3d"));
}

TEST_F(ZarrPython, openVolumeFindsThem) {
  EXPECT_EQ(openVolume(pathOf("ome-3d").string())->layout().dims, (Vec3i{30, 21, 13}));
  EXPECT_EQ(openVolume(pathOf("zstd-dot").string() + "/")->layout().name, "zstd-dot");
  EXPECT_EQ(openVolume(pathOf("plain-4d").string())->layout().time_steps, 3);
  EXPECT_EQ(openVolume(pathOf("plain-4d").string(), {.channel = 2})->layout().time_steps, 1);
  const auto spaced = openVolume(pathOf("ome-3d").string(), {.spacing = Vec3d{3, 4, 5}});
  EXPECT_EQ(spaced->layout().spacing, (Vec3d{3, 4, 5}));
  EXPECT_THAT(errorOf([&] { openVolume(pathOf("zstd-dot").string(), {.channel = 0}); }),
              HasSubstr("the volume has no channels"));
  EXPECT_THAT(errorOf([&] { openVolume(pathOf("ome-4d").string(), {.channel = 2}); }),
              HasSubstr("the volume has 2 channels"));
  EXPECT_THAT(errorOf([&] { openVolume("synth:cube", {.channel = 0}); }),
              HasSubstr("--channel 0 is for VTK images, HDF5 files"));
  EXPECT_THAT(errorOf([&] {
                openVolume(pathOf("zstd-dot").string(), {.dims = Vec3i{1, 1, 1}});
              }),
              HasSubstr("are for raw files"));
}

// Damage of a copy, so that the other tests keep theirs.
class ZarrDamage : public ZarrPython {
 protected:
  fs::path copyOf(const std::string& name) {
    const fs::path copy = work_ / name;
    fs::remove_all(copy);
    fs::copy(pathOf(name), copy, fs::copy_options::recursive);
    return copy;
  }
  TempFolder work_;
};

TEST_F(ZarrDamage, aCutOrChangedChunkIsNeverACrash) {
  for (const char* name :
       {"zlib-dot", "gzip-dot", "zstd-dot", "none-dot", "blosc-lz4-1-dot", "blosc-lz4hc-2-dot",
        "blosc-zstd-0-dot", "blosc-zlib-1-dot", "blosc-blosclz-1-dot"}) {
    SCOPED_TRACE(name);
    const fs::path copy = copyOf(name);
    const int accepted =
        surviveDamage(pathOf(name) / "0.1.2", copy / "0.1.2", 25, 0, [&](const fs::path&) {
          ZarrSource source(copy);
          readAll(source);
        });
    EXPECT_EQ(accepted, 0);
  }
}

TEST_F(ZarrDamage, aBloscHeaderThatLiesIsRefusedBeforeRoomIsMade) {
  const fs::path chunk = copyOf("blosc-lz4-1-dot") / "0.0.0";
  std::string bytes = readFile(chunk);
  const uint32_t huge = 2000000000;
  std::memcpy(bytes.data() + 4, &huge, 4);
  writeFile(chunk, bytes);
  ZarrSource source(chunk.parent_path());
  EXPECT_THAT(errorOf([&] { readAll(source); }),
              AllOf(HasSubstr("0.0.0"), HasSubstr("1024"), HasSubstr("2000000000")));
  EXPECT_LT(source.peakHeldBytes(), 100000U);
}

TEST_F(ZarrDamage, aChunkThatGoesOrChangesWhileOpenIsAnError) {
  const fs::path copy = copyOf("zstd-dot");
  ZarrSource source(copy, {.chunk_cache_bytes = 1});
  readAll(source);
  const std::string bytes = readFile(copy / "1.2.3");
  fs::remove(copy / "1.2.3");
  EXPECT_THAT(errorOf([&] { readAll(source); }),
              AllOf(HasSubstr("1.2.3"), HasSubstr("was there when the volume was opened")));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  writeFile(copy / "1.2.3", bytes);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_THAT(errorOf([&] { readAll(source); }),
              AllOf(HasSubstr("1.2.3"), HasSubstr("changed while the volume was open")));
  EXPECT_TRUE(asText(readAll(*std::make_unique<ZarrSource>(copy))) == voxelsOf("zstd-dot"));
}

TEST_F(ZarrDamage, identityChangesWithTheStore) {
  const fs::path copy = copyOf("zstd-dot");
  const std::string before = ZarrSource(copy).identity();
  EXPECT_EQ(ZarrSource(copy).identity(), before);
  fs::remove(copy / "1.2.3");
  const std::string removed = ZarrSource(copy).identity();
  EXPECT_NE(removed, before);
  std::string header = readFile(copy / ".zarray");
  header.replace(header.find("\"fill_value\": 0"), 15, "\"fill_value\": 1");
  writeFile(copy / ".zarray", header);
  EXPECT_NE(ZarrSource(copy).identity(), removed);
  const fs::path channels = copyOf("plain-5d-channel");
  EXPECT_NE(ZarrSource(channels, {.channel = 0}).identity(),
            ZarrSource(channels, {.channel = 1}).identity());
}

// The folder of the chunk keeps its time.
TEST_F(ZarrDamage, identityChangesWithAChunkThatIsRewrittenInPlace) {
  for (const auto& [store, chunk] :
       {std::pair{"zstd-dot", "1.2.3"}, {"none-dot", "0.1.2"}, {"zstd-slash", "1/2/3"}}) {
    SCOPED_TRACE(store);
    const fs::path copy = copyOf(store);
    const std::string before = ZarrSource(copy).identity();
    ASSERT_TRUE(fs::exists(copy / chunk));
    const auto time = fs::last_write_time(copy / chunk);
    std::string bytes = readFile(copy / chunk);
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    std::fstream(copy / chunk, std::ios::in | std::ios::out | std::ios::binary) << bytes;
    fs::last_write_time(copy / chunk, time);
    EXPECT_NE(ZarrSource(copy).identity(), before);
  }
}

TEST(Zarr, aNegativeScaleIsWarnedOf) {
  const TempFolder folder;
  fs::create_directories(folder / "v.zarr/0");
  writeFile(folder / "v.zarr/0/.zarray",
            R"({"zarr_format": 2, "shape": [2, 2, 2], "chunks": [2, 2, 2], "compressor": null,
                "fill_value": 0, "order": "C", "filters": null, "dtype": "|u1"})");
  writeFile(folder / "v.zarr/.zattrs",
            R"({"multiscales": [{"axes": ["z", "y", "x"], "datasets": [{"path": "0",
                "coordinateTransformations": [{"type": "scale", "scale": [3, 1, -1]}]}]}]})");
  EXPECT_THAT(ZarrSource(folder / "v.zarr").layout().notes,
              testing::ElementsAre(HasSubstr("its spacing is 3 x 1 x -1")));
}

// xarray writes a variable with a coordinate so.
TEST(Zarr, conventionsOfAnArrayAreRead) {
  const TempFolder folder;
  const fs::path array = folder / "s.zarr/v";
  fs::create_directories(array);
  fs::create_directories(folder / "s.zarr/x");
  writeFile(folder / "s.zarr/x/.zarray", "{}");
  const auto write = [&](const std::string& type, const std::string& attributes) {
    writeFile(array / ".zarray",
              R"({"zarr_format": 2, "shape": [2, 2, 2], "chunks": [2, 2, 2], "compressor": null,
                  "fill_value": -999, "order": "C", "filters": null, "dtype": ")" +
                  type + "\"}");
    writeFile(array / ".zattrs", attributes);
  };
  write("<i2", R"({"_ARRAY_DIMENSIONS": ["a", "b", "x"], "scale_factor": 0.5, "add_offset": 10,
                   "_FillValue": -999, "valid_min": -40, "valid_max": 32767})");
  const ZarrSource integers(array);
  EXPECT_EQ(integers.layout().value_scale, 0.5);
  EXPECT_EQ(integers.layout().value_offset, 10);
  EXPECT_THAT(
      integers.layout().notes,
      testing::ElementsAre(testing::HasSubstr("s.zarr/x) are not read"),
                           testing::HasSubstr("voxels of the value -489.5 stand for missing"),
                           testing::HasSubstr("values below -10 are invalid by the file")));
  // Python: base64.b64encode(struct.pack("<d", -999)).
  for (const char* number : {"-999", "[-998, -999]", "\"AAAAAAA4j8A=\""}) {
    write("<f4", fmt::format(R"({{"_FillValue": {}}})", number));
    ZarrSource floats(array);
    EXPECT_THAT(floats.layout().notes, testing::IsEmpty());
    const std::vector<std::byte> voxels = readAll(floats);  // of a chunk that is not there
    float first = 0;
    std::memcpy(&first, voxels.data(), sizeof first);
    EXPECT_TRUE(std::isnan(first)) << number;
  }
}

TEST(Zarr, aFolderThatIsNoImageSaysWhatItHolds) {
  const TempFolder folder;
  fs::create_directories(folder / "a/0");
  writeFile(folder / "a/.zgroup", "{\"zarr_format\": 2}");
  writeFile(folder / "a/0/.zgroup", "{\"zarr_format\": 2}");
  EXPECT_THAT(errorOf([&] { ZarrSource source(folder / "a"); }),
              AllOf(HasSubstr("multiscales"), HasSubstr("a/0")));
  fs::create_directories(folder / "b");
  writeFile(folder / "b/zarr.json", "{\"zarr_format\": 3}");
  EXPECT_THAT(errorOf([&] { openVolume((folder / "b").string()); }), HasSubstr("node_type"));
}

TEST(Zarr, aMissingArrayOrAFolderOutsideIsRefused) {
  const TempFolder folder;
  const auto image = [&](const std::string& path) {
    writeFile(folder / ".zattrs",
              R"({"multiscales": [{"datasets": [{"path": ")" + path + R"("}]}]})");
  };
  writeFile(folder / ".zgroup", "{\"zarr_format\": 2}");
  image("0");
  EXPECT_THAT(errorOf([&] { ZarrSource source(folder.path()); }), HasSubstr("0/.zarray"));
  for (const char* path : {"../x", "/etc", "a/../../b", "", "a//../..", "."}) {
    image(path);
    EXPECT_THAT(errorOf([&] { ZarrSource source(folder.path()); }),
                HasSubstr("expected the path of a folder inside this one"))
        << path;
  }
}

}  // namespace
}  // namespace sluice::zarr_source_test

#include "io/stores/chunk_store.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <future>
#include <thread>
#include <vector>

#include "io/stores/folder_store.h"
#include "io/zarr/reading/zarr_source.h"
#include "tests/io/python_volumes.h"
#include "tests/io/zarr/map_store.h"
#include "tests/io/zarr/zarr_case.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::HasSubstr;

struct StoredCase : ZarrCase {
  static constexpr const char* kScript = "make_zarr3.py";
  static constexpr const char* kModules = "numpy, numcodecs";
};

class ZarrInAStore : public PythonVolumesTest<StoredCase> {
 protected:
  static std::shared_ptr<MapStore> mapOf(const std::string& name) {
    return std::make_shared<MapStore>(pathOf(name));
  }
};

// Missing chunks and shards are the fill value there, too.
TEST_F(ZarrInAStore, thatCannotBeListedHasTheVoxelsOfTheFolder) {
  size_t with_missing = 0;
  for (const StoredCase& c : cases_) {
    SCOPED_TRACE(c.name);
    ZarrSource source(StorePlace{mapOf(c.name), ""}, c.options());
    EXPECT_EQ(source.layout().dims, c.dims);
    EXPECT_FALSE(source.occupancy(0).has_value());
    EXPECT_TRUE(allSteps(source) == voxelsOf(c.name));
    with_missing += c.missing ? 1 : 0;
  }
  EXPECT_GT(with_missing, 3U);
}

TEST_F(ZarrInAStore, isAskedOnceForWhatIsNotThere) {
  for (const StoredCase& c : cases_) {
    if (!c.missing) continue;
    SCOPED_TRACE(c.name);
    const auto map = mapOf(c.name);
    ZarrSource source(StorePlace{map, ""}, c.options());
    source.holdAtMost(1);
    allSteps(source);
    allSteps(source);
    for (const auto& [key, reads] : map->reads) {
      const bool is_header = key.starts_with(".z") || key.ends_with("zarr.json");
      EXPECT_TRUE(map->has(key) || is_header || reads == 1) << key << " " << reads;
    }
  }
}

// Over a link that takes its time, the levels' headers come together.
TEST(ZarrImageInAStore, isExpectedToReadTheHeadersOfAllLevels) {
  for (const bool is_version3 : {false, true}) {
    SCOPED_TRACE(is_version3);
    const TempFolder empty;
    const auto map = std::make_shared<MapStore>(empty.path());
    const std::string levels = R"("multiscales":[{"version":"0.4","axes":[
        {"name":"z","type":"space"},{"name":"y","type":"space"},{"name":"x","type":"space"}],
        "datasets":[{"path":"0"},{"path":"1"},{"path":"2"}]}])";
    std::vector<std::string> headers;
    for (int level = 0; level < 3; ++level) {
      const int side = 64 >> level;
      headers.push_back(fmt::format("{}/{}", level, is_version3 ? "zarr.json" : ".zarray"));
      map->pieces[headers.back()] =
          is_version3 ? fmt::format(R"({{"zarr_format":3,"node_type":"array","shape":[{0},{0},{0}],
                  "data_type":"uint8","fill_value":0,"chunk_key_encoding":{{"name":"default"}},
                  "chunk_grid":{{"name":"regular","configuration":{{"chunk_shape":[16,16,16]}}}},
                  "codecs":[{{"name":"bytes"}}]}})",
                                    side)
                      : fmt::format(R"({{"zarr_format":2,"shape":[{0},{0},{0}],"chunks":[16,16,16],
                  "dtype":"|u1","fill_value":0,"order":"C","compressor":null,"filters":null}})",
                                    side);
    }
    if (is_version3) {
      map->pieces["zarr.json"] =
          R"({"zarr_format":3,"node_type":"group","attributes":{"ome":{)" + levels + "}}}";
    } else {
      map->pieces[".zgroup"] = R"({"zarr_format":2})";
      map->pieces[".zattrs"] = "{" + levels + "}";
    }
    map->before_read = [&](const std::string& key) {
      EXPECT_TRUE(std::ranges::find(headers, key) == headers.end() || !map->expected.empty())
          << key;
    };
    const ZarrSource source(StorePlace{map, ""});
    EXPECT_EQ(source.layout().levels, 3);
    EXPECT_THAT(map->expected, testing::IsSupersetOf(headers));
    for (const std::string& header : headers) EXPECT_EQ(map->reads[header], 1);
    for (const std::string& key : map->expected)
      EXPECT_TRUE(map->has(key) || key.ends_with(".sluice-checksums")) << key;
  }
}

// Neighbouring blocks share chunks: if threads waited for one another, they would read one by one.
TEST_F(ZarrInAStore, aThreadReadsTheOtherChunksWhileOneIsBeingRead) {
  const auto map = mapOf("plain_uint8");
  ZarrSource source(StorePlace{map, ""});
  const size_t others = map->pieces.size() - 2;  // without the metadata
  ASSERT_GT(others, 3U);
  std::atomic<size_t> others_read{0};
  std::promise<void> begun;
  map->before_read = [&](const std::string& key) {
    if (key != "c/0/0/0") {
      ++others_read;
      return;
    }
    begun.set_value();
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (others_read < others && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(others_read, others) << "while c/0/0/0 was being read";
  };
  auto first = std::async(std::launch::async, [&] { return allSteps(source); });
  begun.get_future().wait();
  EXPECT_TRUE(allSteps(source) == voxelsOf("plain_uint8"));
  EXPECT_TRUE(first.get() == voxelsOf("plain_uint8"));
  for (const auto& [key, reads] : map->reads) EXPECT_TRUE(reads == 1 || key == "zarr.json") << key;
}

TEST_F(ZarrInAStore, hasItsLevelsAndAnErrorForAPieceThatChanges) {
  const auto map = mapOf("image");
  ZarrSource source(StorePlace{map, ""});
  ASSERT_EQ(source.levelsAbove().size(), 1U);
  EXPECT_TRUE(asText(readAll(*source.levelsAbove()[0].source)) ==
              readFile(pathOf("image_coarse.bin")));
  map->has_changed = true;
  EXPECT_THAT(errorOf([&] { readAll(source); }), HasSubstr("changed while the volume was open"));
}

TEST_F(ZarrInAStore, aLevelByItselfHasItsScaleFromAround) {
  const ZarrSource source(StorePlace{mapOf("image"), "scale1/image"});
  EXPECT_EQ(source.layout().spacing, (Vec3d{2, 2, 6}));
}

// The index, at the end of the shard, says where each inner chunk lies: offset and length of each,
// x fastest, and a checksum of 4 bytes.
TEST_F(ZarrInAStore, aBoxOfAShardTakesItsInnerChunksAndOneIndex) {
  constexpr Vec3i kInner{5, 4, 2}, kInners{4, 4, 8};
  constexpr uint64_t kIndexBytes = 16 * kInners.x * kInners.y * kInners.z + 4;
  const std::vector<Box3> boxes = {{{0, 0, 0}, {1, 1, 1}},
                                   {{0, 0, 0}, {10, 4, 2}},
                                   {{3, 2, 1}, {6, 6, 5}},
                                   {{6, 1, 1}, {9, 3, 7}}};
  for (const Box3& box : boxes) {
    const auto map = mapOf("one_shard");
    ZarrSource source(StorePlace{map, ""});
    const std::string& shard = map->pieces.at("c/0/0/0");
    uint64_t needed = 0;
    for (int64_t z = box.lo.z / kInner.z; z * kInner.z < box.hi.z; ++z)
      for (int64_t y = box.lo.y / kInner.y; y * kInner.y < box.hi.y; ++y)
        for (int64_t x = box.lo.x / kInner.x; x * kInner.x < box.hi.x; ++x) {
          const auto entry = static_cast<uint64_t>((z * kInners.y + y) * kInners.x + x);
          uint64_t length = 0;
          std::memcpy(&length, shard.data() + shard.size() - kIndexBytes + 16 * entry + 8, 8);
          needed += length;
        }
    source.holdAtMost(uint64_t{1} << 20);
    readBox(source, box, 0);
    uint64_t indices = 0, bytes = 0;
    for (const auto& [from, count] : map->parts["c/0/0/0"])
      (from == PieceBytes::From::kEnd ? indices : bytes) += count;
    EXPECT_EQ(indices, kIndexBytes);
    EXPECT_GE(bytes, needed);
    EXPECT_LE(static_cast<double>(bytes), 1.05 * static_cast<double>(needed));
  }
}

// A shard that goes away after its index was read is no shard of fill values.
TEST_F(ZarrInAStore, aShardThatGoesAwayIsAnError) {
  const auto map = mapOf("one_shard");
  ZarrSource source(StorePlace{map, ""});
  source.holdAtMost(uint64_t{1} << 20);
  readBox(source, {{0, 0, 0}, {1, 1, 1}}, 0);
  map->pieces.erase("c/0/0/0");
  EXPECT_THAT(errorOf([&] { readAll(source); }), HasSubstr("map:c/0/0/0: expected a shard"));
}

TEST(StorePlaceTest, namesWhatIsInsideAndAround) {
  const StorePlace place = folderPlace("/a/b/");
  EXPECT_EQ(place.at("c").key, "/a/b/c");
  EXPECT_EQ(place.lastPart(), "b");
  EXPECT_EQ(place.around().key, "/a");
  EXPECT_EQ(place.around().around().key, "/");
  EXPECT_EQ(place.around().around().around().key, "/");
}

}  // namespace
}  // namespace sluice

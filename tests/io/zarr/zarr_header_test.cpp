#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/metadata/zarr_image.h"
#include "tests/io/image_test_support.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using Members = std::vector<std::pair<std::string, std::string>>;

// The JSON object of sound members with one replaced, or left out if `value` is empty.
std::string objectWith(const Members& members, const std::string& key, const std::string& value) {
  std::string text;
  for (const auto& [name, sound] : members) {
    const std::string& said = name == key ? value : sound;
    if (said.empty()) continue;
    text += (text.empty() ? "{\"" : ", \"") + name + "\": " + said;
  }
  return text + "}";
}

// A sound .zarray with one member replaced, or left out if `value` is empty.
std::string arrayWith(const std::string& key, const std::string& value) {
  const Members members = {
      {"zarr_format", "2"}, {"shape", "[10, 20, 30]"}, {"chunks", "[4, 5, 6]"},
      {"dtype", "\"<u2\""}, {"compressor", "null"},    {"fill_value", "3"},
      {"order", "\"C\""},   {"filters", "null"},       {"dimension_separator", "\"/\""}};
  return objectWith(members, key, value);
}

TEST(ZarrArray, saysShapeChunksTypeAndNames) {
  const ZarrArray array = parseZarrArray(arrayWith("", ""), ".zarray");
  EXPECT_EQ(array.shape, (std::vector<int64_t>{10, 20, 30}));
  EXPECT_EQ(array.chunkBytes(), 4U * 5 * 6 * 2);
  EXPECT_EQ(array.chunkCount(), 3 * 4 * 5);
  EXPECT_EQ(array.fill_value, 3);
  EXPECT_EQ(array.fileName(array.chunkNumber(std::vector<int64_t>{2, 0, 4})), "2/0/4");
  for (int64_t i = 0; i < array.chunkCount(); ++i)
    ASSERT_EQ(array.chunkNumber(array.chunkIndex(i)), i);
  EXPECT_EQ(parseZarrArray(arrayWith("dimension_separator", ""), "").separator, '.');
  EXPECT_EQ(parseZarrArray(arrayWith("fill_value", "null"), "").fill_value, 0);
}

// Without the note every chunk would be a missing one.
TEST(ZarrArray, namesMembersWithoutAMeaning) {
  EXPECT_EQ(parseZarrArray(arrayWith("", ""), ".zarray").notes.size(), 0U);
  std::string text = arrayWith("", "");
  text.replace(text.find("dimension_separator"), 19, "dimension_separatur");
  EXPECT_EQ(
      parseZarrArray(text, "v/.zarray").notes,
      std::vector<std::string>{"v/.zarray: its header has a field without a meaning, which is "
                               "passed over: 'dimension_separatur'"});
}

TEST(ZarrArray, floatFillsMayBeWords) {
  const auto fill = [](const std::string& value) {
    std::string text = arrayWith("fill_value", value);
    text.replace(text.find("<u2"), 3, "<f4");
    return parseZarrArray(text, "").fill_value;
  };
  EXPECT_TRUE(std::isnan(fill("\"NaN\"")));
  EXPECT_EQ(fill("\"Infinity\""), INFINITY);
  EXPECT_EQ(fill("\"-Infinity\""), -INFINITY);
  EXPECT_EQ(fill("-1.5"), -1.5);
  EXPECT_THAT(errorOf([&] { fill("1e300"); }), HasSubstr("that the type holds"));
  EXPECT_THAT(errorOf([&] { fill("\"many\""); }), HasSubstr("'many'"));
}

TEST(ZarrArray, eachFieldIsCheckedByName) {
  struct Wrong {
    const char *key, *value, *said;
  };
  for (const Wrong& wrong : {Wrong{"zarr_format", "4", "version 2 or 3"},
                             {"zarr_format", "", "zarr_format"},
                             {"shape", "[]", "1 to 5 axes"},
                             {"shape", "[10, 0, 30]", "/shape/1"},
                             {"shape", "[10, -2, 30]", "/shape/1"},
                             {"shape", "[10, 2.5, 30]", "/shape/1"},
                             {"shape", "[1, 2, 3, 4, 5, 6]", "1 to 5 axes"},
                             {"shape", "[4000000000, 4000000000, 4000000000]", "2^59"},
                             {"shape", "[18446744073709551615, 1, 1]", "whole number"},
                             {"shape", "7", "an array"},
                             {"chunks", "[4, 5]", "3 extents"},
                             {"chunks", "[4, 5, 0]", "/chunks/2"},
                             {"chunks", "[4000000, 4000000, 4000000]", "voxels a chunk"},
                             {"dtype", "\"<i8\"", "found '<i8'"},
                             {"dtype", "\"<f2\"", "found '<f2'"},
                             {"dtype", "\"u2\"", "found 'u2'"},
                             {"dtype", "\"|u2\"", "found '|u2'"},
                             {"dtype", "[[\"a\", \"<u2\"]]", "/dtype"},
                             {"compressor", "{\"id\": \"lzma\"}", "found 'lzma'"},
                             {"compressor", "{}", "id"},
                             {"compressor", "", "compressor"},
                             {"fill_value", "70000", "that the type holds"},
                             {"fill_value", "-1", "that the type holds"},
                             {"fill_value", "1.5", "that the type holds"},
                             {"fill_value", "\"NaN\"", "a number"},
                             {"order", "\"K\"", "C or F"},
                             {"filters", "[{\"id\": \"delta\"}]", "filters"},
                             {"dimension_separator", "\"-\"", "'.' or '/'"}}) {
    const std::string line =
        errorOf([&] { parseZarrArray(arrayWith(wrong.key, wrong.value), "a/.zarray"); });
    EXPECT_THAT(line, AllOf(testing::StartsWith("a/.zarray: "), HasSubstr(wrong.said)))
        << wrong.key << " " << wrong.value;
  }
  EXPECT_THAT(errorOf([] { parseZarrArray("{", "a/.zarray"); }), HasSubstr("expected JSON"));
  EXPECT_THAT(errorOf([] { parseZarrArray("[]", "a/.zarray"); }), HasSubstr("an object"));
}

// A sound zarr.json of an array with one member replaced, or left out if `value` is empty.
std::string array3With(const std::string& key, const std::string& value) {
  Members members = {
      {"zarr_format", "3"},
      {"node_type", "\"array\""},
      {"shape", "[10, 20, 30]"},
      {"data_type", "\"uint16\""},
      {"chunk_grid", R"({"name": "regular", "configuration": {"chunk_shape": [4, 10, 6]}})"},
      {"chunk_key_encoding", R"({"name": "default"})"},
      {"fill_value", "3"},
      {"codecs", R"([{"name": "bytes", "configuration": {"endian": "little"}}, "crc32c"])"}};
  if (std::none_of(members.begin(), members.end(), [&](const auto& m) { return m.first == key; }))
    members.emplace_back(key, "");
  return objectWith(members, key, value);
}

std::string shardsOf(const std::string& chunks, const std::string& codecs,
                     const std::string& more = "") {
  return R"([{"name": "sharding_indexed", "configuration": {"chunk_shape": )" + chunks +
         R"(, "codecs": )" + codecs + R"(, "index_codecs": ["bytes", "crc32c"])" + more + "}}]";
}

TEST(Zarr3Array, saysWhereAChunkOfAShardLies) {
  const ZarrArray array = parseZarrArray(
      array3With("codecs", shardsOf("[2, 5, 3]", R"(["bytes", "zstd"])")), "zarr.json");
  EXPECT_EQ(array.chunks, (std::vector<int64_t>{2, 5, 3}));
  EXPECT_EQ(array.files, (std::vector<int64_t>{4, 10, 6}));
  EXPECT_EQ(array.fileCount(), 3 * 2 * 5);
  EXPECT_EQ(array.chunksAFile(), 8);
  EXPECT_EQ(array.shardIndexBytes(), 8U * 16 + 4);
  // Chunk (3, 2, 5) is the last but one along y and x of shard (1, 1, 2).
  const ZarrArray::Place place = array.placeOf(array.chunkNumber(std::vector<int64_t>{3, 2, 5}));
  EXPECT_EQ(array.fileName(place.file), "c/1/1/2");
  EXPECT_EQ(place.chunk, 1 * 4 + 0 * 2 + 1);
}

TEST(Zarr3Array, eachFieldIsCheckedByName) {
  struct Wrong {
    std::string key, value, said;
  };
  const std::string bytes = R"(["bytes"])";
  for (const Wrong& wrong :
       {Wrong{"node_type", "\"group\"", "array"},
        {"shape", "[]", "1 to 5 axes"},
        {"data_type", "\"int64\"", "found 'int64'"},
        {"data_type", "{\"name\": \"numpy.datetime64\"}", "/data_type"},
        {"chunk_grid", R"({"name": "rectangular"})", "regular grid"},
        {"chunk_grid", R"({"name": "regular", "configuration": {"chunk_shape": [4, 5]}})",
         "3 extents"},
        {"chunk_grid", R"({"name": "regular"})", "configuration"},
        {"chunk_key_encoding", R"("v1")", "default or v2"},
        {"chunk_key_encoding", R"({"name": "default", "configuration": {"separator": "-"}})",
         "'.' or '/'"},
        {"fill_value", "70000", "that the type holds"},
        {"codecs", "[]", "a list of codecs"},
        {"codecs", R"(["zstd"])", "in this order"},
        {"codecs", R"(["bytes", "lzma"])", "in this order"},
        {"codecs", R"(["bytes", "crc32c", "zstd"])", "in this order"},
        {"codecs", R"(["bytes", "zstd", "gzip"])", "in this order"},
        {"codecs", R"([{"name": "transpose", "configuration": {"order": [0, 0, 1]}}, "bytes"])",
         "each axis"},
        {"codecs", R"([{"name": "bytes", "configuration": {"endian": "middle"}}])",
         "little or big"},
        {"codecs", shardsOf("[3, 5, 3]", bytes), "a whole number makes a shard"},
        {"codecs", shardsOf("[2, 5, 3]", shardsOf("[1, 5, 3]", bytes)), "in this order"},
        {"codecs", shardsOf("[2, 5, 3]", bytes, R"(, "index_location": "middle")"), "start or end"},
        {"storage_transformers", R"([{"name": "a"}])", "no storage transformers"},
        {"irregular", "{}", "no such extension"}}) {
    const std::string line =
        errorOf([&] { parseZarrArray(array3With(wrong.key, wrong.value), "a/zarr.json"); });
    EXPECT_THAT(line, AllOf(testing::StartsWith("a/zarr.json: "), HasSubstr(wrong.said)))
        << wrong.key << " " << wrong.value;
  }
}

std::string imageOf(const std::string& axes, const std::string& level, const std::string& whole) {
  return R"({"multiscales": [{"axes": )" + axes +
         R"(, "datasets": [{"path": "0", "coordinateTransformations": )" + level +
         R"(}, {"path": "1", "coordinateTransformations": [{"type": "scale", "scale": [8, 8, 8]}]}])" +
         (whole.empty() ? "" : ", \"coordinateTransformations\": " + whole) + "}]}";
}
constexpr const char* kZyx =
    R"([{"name": "z", "type": "space", "unit": "millimeter"}, {"name": "y", "type": "space"}, "x"])";

VolumeLayout layoutOf(const std::string& image, const std::string& level = "") {
  return viewZarr(parseZarrArray(arrayWith("", ""), ""), parseZarrImage(image, ".zattrs", level),
                  false, ".zattrs")
      .layout;
}

// world = whole.scale * (level.scale * i + level.translation) + whole.translation
TEST(ZarrImage, transformationsOfTheLevelComeBeforeThoseOfTheImage) {
  const std::string level =
      R"([{"type": "scale", "scale": [2, 3, 4]}, {"type": "translation", "translation": [1, 1, 2]}])";
  const std::string whole =
      R"([{"type": "scale", "scale": [10, 10, 10]}, {"type": "translation", "translation": [5, 0, 0]}])";
  const VolumeLayout layout = layoutOf(imageOf(kZyx, level, whole));
  EXPECT_EQ(layout.dims, (Vec3i{30, 20, 10}));
  EXPECT_EQ(layout.spacing, (Vec3d{40, 30, 20}));
  EXPECT_EQ(layout.origin, (Vec3d{20, 10, 15}));
  EXPECT_EQ(layoutOf(imageOf(kZyx, level, ""), "1").spacing, (Vec3d{8, 8, 8}));
  EXPECT_EQ(layoutOf("{}").spacing, (Vec3d{1, 1, 1}));
}

// Each axis of an image may have a unit of its own.
TEST(ZarrImage, lengthsInSeveralUnitsBecomeThatOfX) {
  const auto axesIn = [](const char* z, const char* y, const char* x) {
    return fmt::format(
        R"([{{"name": "z", "type": "space", "unit": "{}"}}, {{"name": "y", "type": "space", "unit": "{}"}}, {{"name": "x", "type": "space", "unit": "{}"}}])",
        z, y, x);
  };
  const std::string level =
      R"([{"type": "scale", "scale": [500, 2, 0.25]}, {"type": "translation", "translation": [1000, 3, 4]}])";
  const VolumeLayout layout =
      layoutOf(imageOf(axesIn("nanometer", "millimeter", "micrometer"), level, ""));
  EXPECT_EQ(layout.unit, "micrometer");
  EXPECT_EQ(layout.spacing, (Vec3d{0.25, 2000, 0.5}));
  EXPECT_EQ(layout.origin, (Vec3d{4, 3000, 1}));
  // Spellings of one unit are one unit, and a word that is not known is left as it is.
  EXPECT_EQ(layoutOf(imageOf(axesIn("um", "micron", "um"), level, "")).unit, "micrometer");
  EXPECT_EQ(layoutOf(imageOf(axesIn("ell", "um", "um"), level, "")).spacing, (Vec3d{0.25, 2, 500}));
}

TEST(ZarrImage, aNegativeScaleTurnsTheAxis) {
  const VolumeLayout layout =
      layoutOf(imageOf(kZyx, R"([{"type": "scale", "scale": [1, 1, -2]}])", ""));
  EXPECT_EQ(layout.spacing, (Vec3d{2, 1, 1}));
  EXPECT_EQ(layout.axes[0], (Vec3d{-1, 0, 0}));
}

TEST(ZarrImage, saysFrameLevelsAndChannels) {
  const std::string sound = R"([{"type": "scale", "scale": [1, 1, 1]}])";
  const VolumeLayout image = layoutOf(imageOf(kZyx, sound, ""));
  EXPECT_EQ(image.frame, WorldFrame::kPictureRows);
  EXPECT_EQ(image.levels, 2);
  EXPECT_EQ(image.channels, 1);
  EXPECT_EQ(layoutOf("{}").frame, WorldFrame::kNone);
  EXPECT_EQ(layoutOf(R"({"sluice": {"frame": "ras"}})").frame, WorldFrame::kRas);
  EXPECT_THAT(errorOf([&] { layoutOf(R"({"sluice": {"frame": "up"}})"); }), HasSubstr("lps"));
  EXPECT_EQ(parseZarrImage(R"({"omero": {"channels": [{"label": "DAPI"}, {}, 3]}})", "").channels,
            (std::vector<std::string>{"DAPI", "", ""}));
  EXPECT_EQ(
      parseZarrImage("{\"omero\": {\"channels\": [{\"label\": \"\u03b1-tubulin\"}]}}", "").channels,
      std::vector<std::string>{"\u03b1-tubulin"});
}

TEST(ZarrImage, saysHowChannelsLook) {
  const ZarrImage image = parseZarrImage(R"({"omero": {"channels": [
    {"color": "0080FF", "window": {"min": 0, "max": 255, "start": 3, "end": 100.5}},
    {"color": "red", "window": {"start": 5, "end": 5}, "active": false},
    {"window": {"start": "a", "end": 2}, "active": 1}, 7]}})",
                                         "");
  ASSERT_EQ(image.looks.size(), 4U);
  EXPECT_EQ(image.looks[0], (StoredLook{.color = {{0, 128 / 255.0, 1}},
                                        .window = {{3, 100.5}},
                                        .limits = {{0, 255}},
                                        .is_active = true}));
  EXPECT_EQ(image.looks[1], StoredLook{.is_active = false});
  EXPECT_EQ(image.looks[2], StoredLook{});
  EXPECT_EQ(image.looks[3], StoredLook{});
  ASSERT_EQ(image.notes.size(), 3U);
  EXPECT_NE(image.notes[0].find("colour of channel 1, 'red',"), std::string::npos);
  EXPECT_NE(image.notes[1].find("window of channel 1"), std::string::npos);
  EXPECT_NE(image.notes[2].find("window of channel 2"), std::string::npos);
  // Names alone say nothing of looks.
  EXPECT_TRUE(parseZarrImage(R"({"omero": {"channels": [{"label": "a"}, {"active": true}]}})", "")
                  .looks.empty());
}

TEST(ZarrImage, eachFieldIsCheckedByName) {
  const std::string sound = R"([{"type": "scale", "scale": [1, 1, 1]}])";
  struct Wrong {
    std::string text, said;
  };
  for (const Wrong& wrong :
       {Wrong{R"({"multiscales": []})", "one image"},
        {R"({"multiscales": 3})", "an array"},
        {R"({"multiscales": [{}]})", "datasets"},
        {R"({"multiscales": [{"datasets": []}]})", "one level"},
        {R"({"multiscales": [{"datasets": [{"path": 3}]}]})", "a text"},
        {imageOf(R"([{"name": "q", "type": "phase"}, {"name": "y"}, {"name": "x"}])", sound, ""),
         "axis 'q'"},
        {imageOf(R"(["q", "z", "y", "x"])", sound, ""), "4 axes"},
        {imageOf(R"(["z", "x", "x"])", sound, ""), "each of the axes"},
        {imageOf(R"(["t", "y", "x"])", sound, ""), "each of the axes"},
        {imageOf(R"(["t", "z", "y", "x"])", sound, ""), "4 axes"},
        {imageOf(R"(["a", "b", "c", "d", "e", "f"])", sound, ""), "at most 5"},
        {imageOf(kZyx, R"([{"type": "scale", "scale": [1, 1]}])", ""), "3 numbers"},
        {imageOf(kZyx, R"([{"type": "scale", "scale": [1, 0, 1]}])", ""), "spacing"},
        {imageOf(kZyx, R"([{"type": "scale", "scale": [1, 1e300, 1]}])", ""), "spacing"},
        {imageOf(kZyx, R"([{"type": "scale", "path": "s"}])", ""), "scale"},
        {imageOf(kZyx, R"([{"type": "affine"}])", ""), "'affine'"},
        {imageOf(kZyx, sound, R"([{"type": "scale", "scale": [1, 1, "a"]}])"), "a number"},
        {imageOf(kZyx, sound, R"([{"type": "translation", "translation": [1, 1e40, 1]}])"),
         "origin"},
        {R"({"sluice": {"axes": [[1, 0, 0], [0, 1, 0], [0, 2, 0]]}})", "length 1"},
        {R"({"sluice": {"axes": [[1, 0, 0], [0, 1, 0], [0, 1, 0]]}})", "one plane"},
        {R"({"sluice": {"axes": [[1, 0], [0, 1, 0], [0, 0, 1]]}})", "3 numbers"},
        {R"({"sluice": {"levels": 3}})", "an object"},
        {R"({"sluice": {"levels": {"max": "../1"}}})", "inside this one"},
        {R"({"sluice": {"value_scale": 0}})", "values are stored"},
        {R"({"scale_factor": 0})", "values are stored"}}) {
    EXPECT_THAT(errorOf([&] { layoutOf(wrong.text); }),
                AllOf(testing::StartsWith(".zattrs: "), HasSubstr(wrong.said)))
        << wrong.text;
  }
  EXPECT_THAT(errorOf([&] { layoutOf(imageOf(kZyx, sound, ""), "2"); }), HasSubstr("level '2'"));
}

// xarray names axes dim_0, dim_1, ... or as its user does.
TEST(ZarrImage, axesOfOtherNamesAndNoTypeAreOfSpace) {
  ZarrImage image;
  for (const char* const name : {"lev", "lat", "lon"}) {
    ZarrAxis axis;
    axis.name = name;
    image.axes.push_back(axis);
  }
  const ZarrView view =
      viewZarr(parseZarrArray(arrayWith("shape", "[20, 30, 40]"), ""), image, false, "a");
  EXPECT_EQ(view.layout.dims, (Vec3i{40, 30, 20}));
}

TEST(ZarrImage, twoAxesAreNoVolume) {
  std::string text = arrayWith("shape", "[20, 30]");
  text.replace(text.find("[4, 5, 6]"), 9, "[4, 5]");
  EXPECT_THAT(errorOf([&] { viewZarr(parseZarrArray(text, ""), {}, false, "a"); }),
              HasSubstr("3 to 5 axes, found 2"));
}

}  // namespace
}  // namespace sluice

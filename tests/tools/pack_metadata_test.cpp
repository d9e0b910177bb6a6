// The metadata that sluice pack keeps: the times of the steps, and the channels' names, colours and
// windows.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "tests/tools/program.h"

namespace sluice::pack_metadata_test {

using nlohmann::json;

// Two steps of two channels of 2 x 2 x 2 voxels, uncompressed, a chunk each.
void writeStore(const Program& program) {
  const auto write = [&](const std::string& name, const std::string& text) {
    const std::filesystem::path path = program.folder / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
  };
  write("cells.zarr/.zgroup", R"({"zarr_format": 2})");
  write("cells.zarr/0/.zarray",
        R"({"zarr_format": 2, "shape": [2, 2, 2, 2, 2], "chunks": [1, 1, 2, 2, 2], "dtype": "<u2",
            "compressor": null, "fill_value": 0, "order": "C", "filters": null})");
  for (const char* chunk : {"0.0", "0.1", "1.0", "1.1"})
    write("cells.zarr/0/" + std::string(chunk) + ".0.0.0",
          std::string("\1\0\2\0\3\0\4\0\5\0\6\0\7\0\10\0", 16));
  write("cells.zarr/.zattrs", R"({
    "multiscales": [{"version": "0.4", "name": "cells", "axes": [
        {"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"},
        {"name": "z", "type": "space", "unit": "micrometer"},
        {"name": "y", "type": "space", "unit": "micrometer"},
        {"name": "x", "type": "space", "unit": "micrometer"}],
      "datasets": [{"path": "0", "coordinateTransformations": [
        {"type": "scale", "scale": [2.5, 1, 3, 2, 1]},
        {"type": "translation", "translation": [10, 0, 1, 2, 3]}]}]}],
    "omero": {"channels": [
      {"label": "DAPI", "color": "0000FF", "active": true,
       "window": {"min": 0, "max": 4095, "start": 1, "end": 8}},
      {"label": "GFP", "color": "00FF00", "active": false,
       "window": {"min": 5, "max": 4000, "start": 2, "end": 7}}]}})");
}

json attributesOf(const Program& program, const std::string& store) {
  std::ifstream file(program.folder / store / ".zattrs");
  return json::parse(file);
}

// Scale and translation of a level along its first axis, which is time.
std::pair<double, double> timesOf(const json& attributes, size_t level) {
  const json& steps = attributes["multiscales"][0]["datasets"][level]["coordinateTransformations"];
  return {steps[0]["scale"][0], steps[1]["translation"][0]};
}

TEST(PackedMetadata, keepsTheTimesOfTheSteps) {
  const Program program;
  writeStore(program);
  for (const char* options : {"", " --channel GFP"}) {
    ASSERT_EQ(
        program.run(std::string("pack cells.zarr -o p.zarr --force --levels 1") + options).status,
        0);
    const json attributes = attributesOf(program, "p.zarr");
    EXPECT_EQ(attributes["multiscales"][0]["axes"][0],
              json({{"name", "t"}, {"type", "time"}, {"unit", "second"}}));
    const size_t levels = attributes["multiscales"][0]["datasets"].size();
    for (size_t level = 0; level < levels; ++level)
      EXPECT_EQ(timesOf(attributes, level), std::pair(2.5, 10.0));
    for (const char* store : {"cells.zarr", "p.zarr"})
      EXPECT_EQ(program.json(std::string("info ") + store)["times"],
                json({{"step", 2.5}, {"start", 10.0}, {"unit", "second"}}));
  }
  EXPECT_NE(program.run("info p.zarr").output.find("2.5 second apart, the first at 10"),
            std::string::npos);
}

// The unit and the time of the first step are kept, and the volume is no mirror image.
TEST(PackedMetadata, warnsOfTimesThatAreNone) {
  const Program program;
  writeStore(program);
  for (const double wrong : {0.0, -2.0}) {
    json attributes = attributesOf(program, "cells.zarr");
    for (json& level : attributes["multiscales"][0]["datasets"])
      level["coordinateTransformations"][0]["scale"][0] = wrong;
    std::ofstream(program.folder / "cells.zarr" / ".zattrs") << attributes;
    const CommandResult info = program.run("info cells.zarr");
    EXPECT_THAT(info.output,
                testing::HasSubstr(fmt::format(
                    "cells.zarr/.zattrs: its scale along the axis of time is {}: 1 second is used",
                    wrong)));
    EXPECT_EQ(info.output.find("mirror"), std::string::npos);
    EXPECT_EQ(program.json("info cells.zarr")["times"],
              json({{"step", 1.0}, {"start", 10.0}, {"unit", "second"}}));
  }
}

TEST(PackedMetadata, keepsTheLooksOfAllChannelsAndOfOne) {
  const Program program;
  writeStore(program);
  const json source = attributesOf(program, "cells.zarr")["omero"]["channels"];
  ASSERT_EQ(program.run("pack cells.zarr -o all.zarr").status, 0);
  EXPECT_EQ(attributesOf(program, "all.zarr")["omero"]["channels"], source);
  for (const size_t channel : {0, 1}) {
    const std::string name = source[channel]["label"];
    ASSERT_EQ(program.run("pack cells.zarr -o one.zarr --force --channel " + name).status, 0);
    json shown = source[channel];
    shown["active"] = true;  // there is no other
    EXPECT_EQ(attributesOf(program, "one.zarr")["omero"]["channels"], json::array({shown}));
    // It is drawn as the channel of its source.
    const std::string options = " --force --view front --size 40 -o ";
    ASSERT_EQ(program.run("render cells.zarr --channel " + name + options + "a.png").status, 0);
    ASSERT_EQ(program.run("render one.zarr" + options + "b.png").status, 0);
    EXPECT_EQ(program.inFolder("cmp a.png b.png").status, 0);
    // A store of the store has it, too.
    ASSERT_EQ(program.run("pack one.zarr -o again.zarr --force").status, 0);
    EXPECT_EQ(attributesOf(program, "again.zarr")["omero"],
              attributesOf(program, "one.zarr")["omero"]);
  }
}

// Viewers that follow `active` show all channels of a store whose source tells no look.
TEST(PackedMetadata, tellsOfChannelsWhatTheirFileTells) {
  const Program program;
  writeStore(program);
  json attributes = attributesOf(program, "cells.zarr");
  for (json& channel : attributes["omero"]["channels"]) channel = {{"label", channel["label"]}};
  std::ofstream(program.folder / "cells.zarr" / ".zattrs") << attributes;
  ASSERT_EQ(program.run("pack cells.zarr -o p.zarr").status, 0);
  for (const json& channel : attributesOf(program, "p.zarr")["omero"]["channels"])
    EXPECT_TRUE(channel["active"]);
  attributes.erase("omero");
  std::ofstream(program.folder / "cells.zarr" / ".zattrs") << attributes;
  ASSERT_EQ(program.run("pack cells.zarr -o p.zarr --force").status, 0);
  EXPECT_FALSE(attributesOf(program, "p.zarr").contains("omero"));
}

TEST(PackedMetadata, tellsNothingOfAFileThatTellsNothing) {
  const Program program;
  ASSERT_EQ(program.run("pack synth:flow,dims=8x8x8,steps=2 -o p.zarr").status, 0);
  const json attributes = attributesOf(program, "p.zarr");
  EXPECT_FALSE(attributes.contains("omero"));
  EXPECT_FALSE(attributes["multiscales"][0]["axes"][0].contains("unit"));
  EXPECT_EQ(timesOf(attributes, 0), std::pair(1.0, 0.0));
  EXPECT_TRUE(program.json("info p.zarr")["times"].is_null());
}

}  // namespace sluice::pack_metadata_test

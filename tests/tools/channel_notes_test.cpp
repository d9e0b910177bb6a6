// Lines that sluice prints about the channels of a picture: each comes once, and names its channel.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/tools/channels_fixture.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::Not;

// Changes a file of JSON.
void edit(const std::filesystem::path& path, const std::function<void(nlohmann::json&)>& change) {
  nlohmann::json content = nlohmann::json::parse(std::ifstream(path));
  change(content);
  std::ofstream(path) << content;
}

TEST_F(Channels, warningOfALookNamesItsChannel) {
  const std::string line = "render cells.ome.zarr --size 32 -o a.png --force --label 60000=red ";
  const std::string both = program_.run(line + "--channel 2,Actin").output;
  EXPECT_THAT(both, HasSubstr("warning: channel 2 (Spots): --label 60000=red: no voxel has this"));
  EXPECT_THAT(both, HasSubstr("warning: channel 1 (Actin): --label 60000=red: no voxel has this"));
  EXPECT_THAT(program_.run(line + "--channel 2").output,
              HasSubstr("warning: --label 60000=red: no voxel has this label"));
}

TEST_F(Channels, invertedOneIsNotedAndPackedAsSuch) {
  const auto invert = [](nlohmann::json& content) {
    content["omero"]["channels"][1]["inverted"] = true;
    content["omero"]["channels"][2]["inverted"] = false;
  };
  edit(program_.folder / "cells.ome.zarr/.zattrs", invert);
  const std::string more = " --size 32 -o a.png --force";
  const std::string note = "channel 1 (Actin) is inverted in the file";
  const std::string lines = program_.run("render cells.ome.zarr" + more).output;
  EXPECT_THAT(lines, HasSubstr("warning: cells.ome.zarr: " + note));
  EXPECT_THAT(lines, Not(HasSubstr("channel 2 (Spots) is inverted")));
  // A channel by itself gets the look of any volume.
  EXPECT_THAT(program_.run("render cells.ome.zarr --channel 1" + more).output,
              Not(HasSubstr("inverted")));
  ASSERT_EQ(program_.run("pack cells.ome.zarr -o p.zarr").status, 0);
  EXPECT_THAT(program_.run("render p.zarr" + more).output, HasSubstr("p.zarr: " + note));
}

TEST_F(Channels, aColourThatIsNoneIsNotedAndReplacedByOneOfItsOwn) {
  edit(program_.folder / "cells.ome.zarr/.zattrs", [](nlohmann::json& content) {
    nlohmann::json& channels = content["omero"]["channels"];
    channels[0]["color"] = "F00";
    channels[1]["color"] = "00FF00";  // the usual one of the first channel
  });
  const std::string lines =
      program_.run("render cells.ome.zarr --channel 0,1 --size 32 -o a.png --force").output;
  const std::string note = "the colour of channel 0, 'F00', in omero is not six";
  const size_t at = lines.find(note);
  ASSERT_NE(at, std::string::npos) << lines;
  EXPECT_EQ(lines.find(note, at + 1), std::string::npos) << lines;
  EXPECT_THAT(lines, HasSubstr("1:00ff00"));
  EXPECT_THAT(lines, Not(HasSubstr("0:00ff00")));
}

TEST_F(Channels, levelWithoutThemIsNotedOnce) {
  ASSERT_EQ(program_.run("pack cells.ome.zarr -o p.zarr --chunk 16 --levels 1").status, 0);
  edit(program_.folder / "p.zarr/1/.zarray",
       [](nlohmann::json& array) { array["shape"][0] = array["shape"][0].get<int>() - 3; });
  std::filesystem::remove(program_.folder / "p.zarr/1/.sluice-checksums");  // of four channels
  for (const char* channels : {"", "--channel 1", "--channel 0,2"}) {
    const std::string lines =
        program_.run(std::string("render p.zarr --size 32 -o a.png --force ") + channels).output;
    const std::string note = "level 1 is left out: ";
    const size_t at = lines.find(note);
    ASSERT_NE(at, std::string::npos) << lines;
    EXPECT_THAT(lines.substr(at), HasSubstr("it has 1 channel, the first level has 4\n"));
    EXPECT_EQ(lines.find(note, at + 1), std::string::npos) << lines;
  }
}

}  // namespace
}  // namespace sluice

// The budget that a refusal of several channels names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/program.h"

namespace sluice::channel_memory_test {

using testing::HasSubstr;

// Four channels of 96 x 96 x 96 voxels, a chunk each, all of which a file shows at first.
void writeChannels(const Program& program) {
  const std::filesystem::path store = program.folder / "cells.zarr";
  std::filesystem::create_directories(store / "0");
  writeFile(store / ".zgroup", R"({"zarr_format": 2})");
  writeFile(store / "0/.zarray",
            R"({"zarr_format": 2, "shape": [4, 96, 96, 96], "chunks": [1, 96, 96, 96],
                "dtype": "<u2", "compressor": null, "fill_value": 0, "order": "C",
                "filters": null})");
  std::string channels;
  for (int c = 0; c < 4; ++c) {
    std::string voxels(2 * 96 * 96 * 96, '\0');
    for (size_t i = 0; i < voxels.size(); i += 2)
      voxels[i] = static_cast<char>((i / 2 * static_cast<size_t>(7 + c)) % 251);
    writeFile(store / fmt::format("0/{}.0.0.0", c), voxels);
    channels += fmt::format(R"({}{{"label": "{}", "color": "00FF0{}", "active": true}})",
                            c > 0 ? ", " : "", c, c);
  }
  writeFile(store / ".zattrs",
            R"({"multiscales": [{"version": "0.4", "axes": [{"name": "c", "type": "channel"},
                {"name": "z", "type": "space"}, {"name": "y", "type": "space"},
                {"name": "x", "type": "space"}], "datasets": [{"path": "0"}]}],
                "omero": {"channels": [)" +
                channels + "]}}");
}

// Nobody has to try twice.
TEST(ChannelMemory, aRefusalNamesABudgetThatDrawsAllChannels) {
  const Program program;
  writeChannels(program);
  for (const char* options : {"", " --block 8", " --over synth:phantom,dims=120x120x120"}) {
    SCOPED_TRACE(options);
    const std::string line = fmt::format(
        "render cells.zarr{} --threshold 20 --size 300 --force -q -o a.png --memory ", options);
    const CommandResult refused = program.run(line + "500K");
    EXPECT_EQ(refused.status, 1);
    const std::string before = "look at it, and ";
    ASSERT_THAT(refused.output, HasSubstr(before));
    const size_t at = refused.output.find(before) + before.size();
    const std::string budget = refused.output.substr(at, refused.output.find(' ', at) - at);
    const CommandResult drawn = program.run(line + budget);
    EXPECT_EQ(drawn.status, 0) << budget << ": " << drawn.output;
    std::filesystem::remove_all(program.folder / "cache");
  }
}

}  // namespace sluice::channel_memory_test

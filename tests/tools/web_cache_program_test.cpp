// The cache of servers' data when its folder has no room, or there is no folder for it.
#include <gmock/gmock.h>
#include <sluice/volume.h>

#include <algorithm>
#include <string>

#include "tests/io/web/web_server.h"
#include "tests/support/file_size_limit.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class WebCacheProgram : public testing::Test {
 protected:
  WebCacheProgram() {
    const CommandResult made = at_server_.run(
        "pack synth:shells,dims=90x80x70 -q -o v.zarr --zarr 3 --chunk 32 --shard 64,64,64 "
        "--levels auto");
    EXPECT_EQ(made.status, 0) << made.output;
  }
  // A picture of the volume and of another one over it, which share the cache.
  std::string picture(const WebServer& server, const std::string& more) const {
    return "render " + server.address() + "/v.zarr --over " + server.address() +
           "/v.zarr --size 64 --threshold 100 --force " + more;
  }

  const Program at_server_, program_;
};

TEST_F(WebCacheProgram, aFullDiskIsOneWarningAndThePictureIsDrawn) {
  const WebServer server(at_server_.folder.path());
  ASSERT_EQ(program_.run(picture(server, "-q -o whole.png")).status, 0);
  if (program_.inFolder("mkdir disk && mount -t tmpfs -o size=64k tmpfs disk").status != 0)
    GTEST_SKIP() << "root, who may mount a tmpfs, is missing";
  program_.inFolder("head -c 65536 /dev/zero >disk/other");
  const std::string cache = " --cache-dir disk --cache 1G ";
  // The summary goes elsewhere.
  const CommandResult drawn = program_.run(picture(server, "-o a.png" + cache) + " 2>&1 >out");
  const CommandResult quiet = program_.run(picture(server, "-q -o b.png" + cache));
  program_.inFolder("rm disk/other");
  const CommandResult room = program_.run(picture(server, "-o c.png" + cache) + " 2>&1 >out");
  const bool has_pieces = program_.inFolder("test -n \"$(ls disk/pieces)\"").status == 0;
  program_.inFolder("umount disk");
  EXPECT_EQ(drawn.status, 0);
  EXPECT_TRUE(isOneLine(drawn.output)) << drawn.output;
  EXPECT_THAT(drawn.output, AllOf(HasSubstr("warning: the cache does not keep all that is read: "
                                            "disk: No space left on device"),
                                  HasSubstr("--cache-dir")));
  EXPECT_EQ(quiet.status, 0);
  EXPECT_EQ(quiet.output, "");
  EXPECT_EQ(room.status, 0);
  EXPECT_TRUE(has_pieces);
  const CommandResult same =
      program_.inFolder("cmp whole.png a.png && cmp whole.png b.png && cmp whole.png c.png");
  EXPECT_EQ(same.status, 0) << same.output;
}

// The library says so among the warnings of the volume, if it happens while the volume is opened.
TEST_F(WebCacheProgram, aFullDiskIsAWarningOfTheVolume) {
  const WebServer server(at_server_.folder.path());
  VolumeOptions options;
  options.web.cache_folder = (program_.folder / "kept").string();
  options.web.cache_bytes = 1 << 30;
  const VolumeInfo info = [&] {
    const FileSizeLimit full(100);
    return Volume(server.address() + "/v.zarr", options).info();
  }();
  EXPECT_THAT(info.warnings, ElementsAre(AllOf(HasSubstr(options.web.cache_folder + ": "),
                                               HasSubstr("--cache-dir"))));
}

TEST_F(WebCacheProgram, withoutAFolderThereIsOneLineAndNoFile) {
  const WebServer server(at_server_.folder.path());
  const Program empty;
  const CommandResult result =
      empty.inFolder("env -u HOME -u XDG_CACHE_HOME " SLUICE_PROGRAM " info " + server.address() +
                     "/v.zarr --cache 1G");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(isOneLine(result.output)) << result.output;
  EXPECT_THAT(result.output, AllOf(HasSubstr("--cache: expected a folder"), HasSubstr("HOME"),
                                   HasSubstr("--cache-dir")));
  EXPECT_TRUE(std::filesystem::is_empty(empty.folder.path()));
}

}  // namespace
}  // namespace sluice

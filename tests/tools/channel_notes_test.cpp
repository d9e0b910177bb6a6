// Lines that sluice prints about the channels of a picture: each comes once, and names its channel.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/channels_fixture.h"

namespace sluice {
namespace {

using testing::HasSubstr;

TEST_F(Channels, warningOfALookNamesItsChannel) {
  const std::string line = "render cells.ome.zarr --size 32 -o a.png --force --label 60000=red ";
  const std::string both = program_.run(line + "--channel 2,Actin").output;
  EXPECT_THAT(both, HasSubstr("warning: channel 2 (Spots): --label 60000=red: no voxel has this"));
  EXPECT_THAT(both, HasSubstr("warning: channel 1 (Actin): --label 60000=red: no voxel has this"));
  EXPECT_THAT(program_.run(line + "--channel 2").output,
              HasSubstr("warning: --label 60000=red: no voxel has this label"));
}

}  // namespace
}  // namespace sluice

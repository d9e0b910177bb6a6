// The errors of channels that share the memory.
#include "src/library/drawing/scene/channel_shares.h"

#include <gmock/gmock.h>

#include "src/base/error.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::HasSubstr;

std::string errorOfShare(const Error& error, size_t channels) {
  return errorOf([&] { failOfShare(error, channels); });
}

TEST(ChannelShares, areToldOnlyWhereMemoryIsShort) {
  const Error damage("v.nrrd: ends too early", Error::Kind::kInput);
  EXPECT_EQ(errorOfShare(damage, 1), damage.what());
  EXPECT_EQ(errorOfShare(damage, 2), damage.what());
  const Error full("disk full", Error::Kind::kSystem);
  EXPECT_EQ(errorOfShare(full, 3), full.what());
  const Error shortage("no room", Error::Kind::kMemory);
  EXPECT_EQ(errorOfShare(shortage, 1), shortage.what());
  EXPECT_THAT(errorOfShare(shortage, 2), HasSubstr("no room (2 channels share the memory"));
}

// Channels of one file that have grids of their own, as those of Imaris and BigDataViewer may.
TEST(BlendedLayers, ofOneFileAreToldApartInMessages) {
  VolumeLayout first, second;
  first.path = second.path = "cells.ims";
  second.channel = 2;
  second.dims = {2, 2, 2};
  const auto obstacle = blendObstacle({}, {}, {&first, &second});
  ASSERT_TRUE(obstacle);
  EXPECT_FALSE(obstacle->is_option);
  EXPECT_THAT(obstacle->line, HasSubstr("channel 2 of cells.ims is on another grid of voxels than "
                                        "channel 0; leave out --combine"));
}

}  // namespace
}  // namespace sluice

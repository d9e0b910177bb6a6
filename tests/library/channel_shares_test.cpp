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

}  // namespace
}  // namespace sluice

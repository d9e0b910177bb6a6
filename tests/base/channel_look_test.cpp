#include "src/base/looks/channel_look.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

TEST(ChannelLook, textsAreReadAndWritten) {
  const std::pair<const char*, ChannelLook> looks[] = {
      {"0:green", {.channel = "0", .map = "green"}},
      {"GFP 488:0000ff,400:3000", {.channel = "GFP 488", .map = "0000ff", .range = {{400, 3000}}}},
      {"1:,-0.5:1e+06,0.25", {.channel = "1", .range = {{-0.5, 1e6}}, .opacity = 0.25}},
      {"1:red,0.5", {.channel = "1", .map = "red", .opacity = 0.5}},
      // Names may hold colons; descending ranges turn a map round.
      {"em:488:hot,9:3", {.channel = "em:488", .map = "hot", .range = {{9, 3}}}}};
  for (const auto& [text, look] : looks) {
    EXPECT_EQ(parseChannelLook(text), look) << text;
    EXPECT_EQ(parseChannelLook(channelLookText(look)), look) << text;
  }
}

TEST(ChannelLook, rejectsWhatIsNone) {
  for (const char* text :
       {"", "0", ":green", "0:green,", "0:green,5", "0:green,-0.1", "0:a,5:5", "0:a,1:2,3:4",
        "0:a,0.1,1:2", "0:a,1:2,0.1,0.1", "0:a,1:x", "0:a,1:inf", "0:a,nan", "0:a,1:2 "})
    EXPECT_EQ(parseChannelLook(text), std::nullopt) << text;
}

TEST(ChannelLook, isOfAChannelByNumberOrName) {
  const ChannelLook look{.channel = "1"};
  EXPECT_TRUE(isLookOf(look, "1", "GFP"));
  EXPECT_FALSE(isLookOf(look, "2", "GFP"));
  EXPECT_TRUE(isLookOf({.channel = "GFP"}, "2", "GFP"));
  EXPECT_FALSE(isLookOf({.channel = ""}, "2", ""));
}

}  // namespace
}  // namespace sluice

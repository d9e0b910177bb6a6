// Numbers that cannot be drawn are refused at every source of a view: a file, a wish, an option.
#include "src/view/state/view_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "src/view/state/files/state_file.h"
#include "tests/support/error_of.h"
#include "tests/support/wrong_states.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

VolumeInfo shells() {
  VolumeInfo info;
  info.name = "shells";
  info.dims = {24, 20, 16};
  return info;
}

void parseFor(const std::string& json) {
  const StateFile file = parseState(json, "a.json");
  requireFits(file.state, file.path, shells(), "a.json");
}

TEST(ViewCheck, refusesEachWrongNumberByFileAndField) {
  parseFor(rightState());
  const std::vector<WrongState> wrong = wrongStates();
  EXPECT_GE(wrong.size(), 200U);
  for (const WrongState& state : wrong) {
    const std::string said = errorOf([&] { parseFor(state.json); });
    EXPECT_THAT(said, StartsWith("a.json: expected ")) << state.json;
    // The field itself, its parent, or for a path as a whole the path.
    EXPECT_THAT(said, HasSubstr(state.field.starts_with("/path") ? "/path" : state.field))
        << state.json;
    EXPECT_THAT(said, HasSubstr(", found ")) << state.json;
  }
}

TEST(ViewCheck, numbersThatJsonHasNotAreRefused) {
  for (const char* number : {"1e999", "-1e999", "NaN", "Infinity", "0x10", "1,"})
    EXPECT_THAT(
        errorOf([&] {
          parseFor(R"({"sluice": "view", "look": {"threshold": )" + std::string(number) + "}}");
        }),
        StartsWith("a.json: expected JSON"));
}

TEST(ViewCheck, refusesWhatAFieldOfTextMayLeaveInAView) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double wrong : {kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    ViewState state;
    state.look.threshold = wrong;
    ASSERT_TRUE(faultOf(state));
    EXPECT_EQ(faultOf(state)->field, "/look/threshold");
    state = {};
    state.look.range = std::array{0.0, wrong};
    ASSERT_TRUE(faultOf(state));
    EXPECT_EQ(faultOf(state)->field, "/look/range");
    state = {};
    state.step_vox = wrong;
    ASSERT_TRUE(faultOf(state));
    EXPECT_EQ(faultOf(state)->field, "/step");
    state = {};
    state.clip_planes = {{{0, 0, 1}, wrong}};
    ASSERT_TRUE(faultOf(state));
  }
  EXPECT_FALSE(faultOf(ViewState()));
}

}  // namespace
}  // namespace sluice

#include "src/base/files/json_field.h"

#include <gmock/gmock.h>

#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::HasSubstr;

TEST(ParseJson, refusesAKeyThatIsThereTwice) {
  EXPECT_THAT(errorOf([] { parseJson(R"({"a": 1, "b": 2, "a": 3})", "f"); }),
              HasSubstr("f: expected each key of an object once, found 'a' twice"));
  EXPECT_THAT(errorOf([] { parseJson(R"([{"x": {"q": 1, "q": 1}}])", "f"); }),
              HasSubstr("'q' twice"));
  EXPECT_EQ(parseJson(R"([{"a": {"a": 1}}, {"a": [{"a": 2}, {"a": 3}]}])", "f").size(), 2U);
}

TEST(ParseJson, refusesDepthAndWhatIsNoJson) {
  EXPECT_THAT(errorOf([] { parseJson(std::string(40, '['), "f"); }),
              HasSubstr("levels of nesting"));
  EXPECT_THAT(errorOf([] { parseJson("{\"\x1b[31m", "f"); }), testing::Not(HasSubstr("\x1b")));
}

}  // namespace
}  // namespace sluice

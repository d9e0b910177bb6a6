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

TEST(ParseJson, saysThatAFileIsEmptyOrNoUtf8) {
  using namespace std::string_literals;
  for (const char* empty : {"", " \n\t"})
    EXPECT_EQ(errorOf([&] { parseJson(empty, "f"); }), "f: expected JSON, found an empty file");
  for (const std::string& wide :
       {"\xff\xfe{\0}\0"s, "\xfe\xff\0{\0}"s, "{\0}\0"s, "\0{\0}"s, "\0\0\0{\0\0\0}"s, "\0\0"s})
    EXPECT_THAT(errorOf([&] { parseJson(wide, "f"); }), HasSubstr("save it as UTF-8"));
  EXPECT_EQ(parseJson("\xef\xbb\xbf{}", "f").size(), 0U);  // the mark of UTF-8
  EXPECT_EQ(parseJson("7", "f"), 7);
}

TEST(Printable, keepsCharactersAndReplacesOtherBytes) {
  for (const char* text : {"DAPI", "\u03b1-tubulin", "\u00b5m", "\u7d30\u80de", "\U0001f52c"})
    EXPECT_EQ(printable(text), text);
  EXPECT_EQ(printable("a\nb\t\x1b[31m\x7f"), "a?b??[31m?");
  // Control characters of 8 bits, a line's end, a turned direction of writing and one of no width.
  EXPECT_EQ(printable("\u009b|\u2028|\u202e|\u200b"), "?|?|?|?");
  // Latin-1, a character that is cut off, one that is written too long, half of a pair, too large.
  EXPECT_EQ(printable("\xb5m"), "?m");
  EXPECT_EQ(printable("a\xce"), "a?");
  EXPECT_EQ(printable("\xc0\xaf|\xe0\x80\xaf"), "??|???");
  EXPECT_EQ(printable("\xed\xa0\x80|\xf4\x90\x80\x80"), "???|????");
}

TEST(Printable, cutsBetweenCharacters) {
  EXPECT_EQ(printable("abcdef", 6), "abcdef");
  EXPECT_EQ(printable("abcdefg", 6), "abcdef...");
  EXPECT_EQ(printable("\u03b1\u03b2\u03b3", 5), "\u03b1\u03b2...");
}

}  // namespace
}  // namespace sluice

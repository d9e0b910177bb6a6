#include "io/headers/file_set.h"

#include <gmock/gmock.h>

#include "tests/io/headers/volume_files.h"

namespace sluice::file_set_test {
namespace {

using testing::HasSubstr;

TEST(FileSetTest, aPatternNumbersFilesAsPrintfDoes) {
  const FileSet plain = parseFilePattern("p", "quarter.%d", "1", "93", "1");
  EXPECT_EQ(plain.count(), 93);
  EXPECT_EQ(plain.name(0), "quarter.1");
  EXPECT_EQ(plain.name(92), "quarter.93");
  const FileSet padded = parseFilePattern("p", "a%%b_%03u.raw", "8", "13", "2");
  EXPECT_EQ(padded.count(), 3);
  EXPECT_EQ(padded.name(1), "a%b_010.raw");
  const FileSet backwards = parseFilePattern("p", "%x%%", "16", "10", "-3");
  EXPECT_EQ(backwards.count(), 3);
  EXPECT_EQ(backwards.name(2), "a%");
  EXPECT_EQ(parseFilePattern("p", "%4d", "-7", "-7", "1").name(0), "  -7");
  EXPECT_EQ(parseFilePattern("p", "%04d", "-7", "-7", "1").name(0), "-007");
}

TEST(FileSetTest, anEnormousPatternCostsNothing) {
  const FileSet files = parseFilePattern("p", "f%d", "0", "9007199254740992", "1");
  EXPECT_EQ(files.count(), 9007199254740993);
  EXPECT_EQ(files.name(9007199254740992), "f9007199254740992");
}

TEST(FileSetTest, rejectsPatternsWithoutASingleNumber) {
  for (const char* pattern : {"plain", "%s", "%d_%d", "%", "%5", "a%n", "%999d", "%%d", "%-3d", ""})
    EXPECT_THAT(errorOf([&] { parseFilePattern("p", pattern, "1", "2", "1"); }),
                testing::StartsWith("p: "))
        << pattern;
}

TEST(FileSetTest, rejectsNumbersThatMakeNoCount) {
  const char* const cases[][3] = {{"1", "5", "0"},
                                  {"5", "1", "1"},
                                  {"1", "5", "-1"},
                                  {"x", "5", "1"},
                                  {"1", "", "1"},
                                  {"1", "5.5", "1"},
                                  {"1", "99999999999999999999", "1"},
                                  {"-9223372036854775808", "1", "1"}};
  for (const auto& [first, last, step] : cases)
    EXPECT_THAT(
        errorOf([&, f = first, l = last, s = step] { parseFilePattern("p", "%d", f, l, s); }),
        testing::StartsWith("p: "))
        << first << " " << last << " " << step;
}

TEST(FileSetTest, rejectsNamesThatWouldSpoilATerminal) {
  FileSet files;
  EXPECT_THAT(errorOf([&] { addFileName("p", "a\033[2J", files); }), HasSubstr("'a?[2J'"));
  EXPECT_THAT(errorOf([&] { addFileName("p", "", files); }), HasSubstr("no name"));
  addFileName("p", "schädel 1.raw", files);
  EXPECT_EQ(files.name(0), "schädel 1.raw");
}

}  // namespace
}  // namespace sluice::file_set_test

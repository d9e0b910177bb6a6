#include "src/base/files/shell_word.h"

#include <gtest/gtest.h>

#include <cctype>
#include <random>

#include "tests/support/run_command.h"

namespace sluice {
namespace {

TEST(ShellWord, staysItselfWhereItMay) {
  EXPECT_EQ(shellWord("a/b-1_2.nrrd"), "a/b-1_2.nrrd");
  EXPECT_EQ(shellWord(""), "''");
  EXPECT_EQ(shellWord("two words"), "'two words'");
  EXPECT_EQ(shellWord("it's"), "'it'\\''s'");
  EXPECT_EQ(shellWord("caf\xc3\xa9"), "'caf\xc3\xa9'");
}

TEST(ShellWord, escapesWhatATerminalWouldObey) {
  EXPECT_EQ(shellWord("a\nrm -rf ~\n"), "$'a\\nrm -rf ~\\n'");
  EXPECT_EQ(shellWord("\x1b[31mred"), "$'\\033[31mred'");
  EXPECT_EQ(shellWord("it's\t\\"), "$'it\\'s\\011\\\\'");
  EXPECT_EQ(shellWord("\x7f"), "$'\\177'");
  EXPECT_EQ(shellWord("\xc2\x9b"
                      "31m"),
            "$'\\302\\23331m'")
      << "a control of one byte in Latin 1";
  EXPECT_EQ(shellWord("\xe2\x80\xae"
                      "gnp"),
            "$'\\342\\200\\256gnp'")
      << "writing turned round";
  EXPECT_EQ(shellWord("\xff"), "$'\\377'") << "no UTF-8";
  EXPECT_EQ(shellWord("\xc3"), "$'\\303'") << "cut off";
  EXPECT_EQ(shellWord("\xed\xa0\x80"), "$'\\355\\240\\200'") << "half a character of UTF-16";
}

TEST(ShellWord, namesAndTextsStayReadable) {
  EXPECT_EQ(shownName("two words"), "two words");
  EXPECT_EQ(shownName("a\nb"), "$'a\\nb'");
  EXPECT_EQ(withoutControls("a\nb\x1b[2Jc\xff"), "a\\nb\\x1b[2Jc\\xff");
  EXPECT_EQ(withoutControls("a\nb\r", "\n\t"), "a\nb\\r");
}

// The shell itself is the judge: it must read back the quoted text.
TEST(ShellWord, isReadBackByTheShell) {
  if (!haveProgram("bash")) GTEST_SKIP() << "bash is not installed";
  std::mt19937 random(7);
  std::string all;
  for (int c = 1; c < 256; ++c) all += static_cast<char>(c);
  std::vector<std::string> words = {all, "$(touch x)", "`id`", "a\nb", "!x", "\\", "'", "$'a'"};
  for (int i = 0; i < 20; ++i) {
    std::string word;
    for (int n = 0; n < 12; ++n) word += static_cast<char>(1 + random() % 255);
    words.push_back(word);
  }
  for (const std::string& word : words) {
    const std::string quoted = shellWord(word);
    for (const char c : quoted)
      EXPECT_FALSE(std::iscntrl(static_cast<unsigned char>(c)) != 0) << quoted;
    EXPECT_EQ(runCommand("bash -c " + shellQuoted("printf %s " + quoted)).output, word) << quoted;
  }
}

}  // namespace
}  // namespace sluice

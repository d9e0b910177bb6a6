#include "src/base/files/file_kind.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <string>

#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

class FileKinds : public testing::Test {
 protected:
  bool replaces(const std::string& content, FileKind kind) {
    writeFile(folder_ / "file", content);
    return mayReplace(folder_ / "file", kind);
  }
  const TempFolder folder_;
};

TEST_F(FileKinds, knowAnEntryOfTheOutermostObjectAlone) {
  EXPECT_TRUE(replaces(R"({"sluice": "report"})", FileKind::kReport));
  EXPECT_TRUE(replaces("\n {\"a\": [1, {}], \"b\": {\"c\": 2}, \"sluice\": \"report\"}",
                       FileKind::kReport));
  for (const char* other :
       {R"({"sluice": "view"})", R"({"a": "report"})", R"({"a": {"sluice": "report"}})",
        R"([{"sluice": "report"}])", R"({"sluice": ["report"]})", R"({"sluice": {"a": "report"}})",
        R"("sluice")", R"({"sluice":)", "", " ", "{", "sluice: report", R"({"sluice": 1})"})
    EXPECT_EQ(replaces(other, FileKind::kReport), *other == '\0') << other;
  EXPECT_TRUE(replaces(R"({"sluice_transfer_function": 1})", FileKind::kTransferFunction));
  EXPECT_FALSE(replaces(R"({"a": {"sluice_transfer_function": 1}})", FileKind::kTransferFunction));
  // A log is an object a line, the mark in the first.
  EXPECT_TRUE(replaces("{\"sluice\":\"log\"}\n{\"keys\":1}\n{\"cut", FileKind::kLog));
  EXPECT_FALSE(replaces("{\"keys\":1}\n{\"sluice\":\"log\"}\n", FileKind::kLog));
}

TEST_F(FileKinds, replaceWhatHoldsNothing) {
  for (const FileKind kind : {FileKind::kReport, FileKind::kRaw, FileKind::kPng}) {
    EXPECT_TRUE(mayReplace(folder_ / "none", kind));
    EXPECT_TRUE(mayReplace(folder_ / "none" / "none", kind));
    EXPECT_TRUE(mayReplace("/dev/null", kind));
    EXPECT_TRUE(replaces("", kind));
    EXPECT_FALSE(mayReplace(folder_.path(), kind));
    EXPECT_FALSE(replaces("x", kind));
  }
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_TRUE(mayReplace(pipe, FileKind::kReport)) << "and it is not waited for";
  writeFile(folder_ / "notes", "mine");
  fs::create_symlink("notes", folder_ / "link");
  EXPECT_FALSE(mayReplace(folder_ / "link", FileKind::kReport));
}

TEST_F(FileKinds, aVolumeWithoutAHeaderIsNeverKnown) {
  EXPECT_FALSE(replaces(softwareMark(), FileKind::kRaw));
}

// A film's mark lies behind the tables of its frames.
TEST_F(FileKinds, knowAFilmByItsDescription) {
  const std::string head = std::string("\0\0\0\x20", 4) + "ftypisom";
  EXPECT_TRUE(replaces(head + std::string(100'000, 't') + softwareMark(), FileKind::kFilm));
  EXPECT_FALSE(replaces(head + std::string(100'000, 't'), FileKind::kFilm));
  EXPECT_FALSE(replaces("a text of " + softwareMark(), FileKind::kFilm));
}

}  // namespace
}  // namespace sluice

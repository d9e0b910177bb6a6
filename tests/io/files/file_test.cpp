#include "io/files/file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <array>

#include "tests/io/headers/volume_files.h"

namespace sluice {
namespace {

using testing::HasSubstr;

std::string readText(File& file, uint64_t offset, size_t length) {
  std::string text(length, '\0');
  file.readAt(offset, std::as_writable_bytes(std::span(text)));
  return text;
}

TEST(FileTest, readsAtPositionsAndCountsTheBytes) {
  const TempFolder folder;
  File file(folder.write("f", "0123456789"));
  EXPECT_EQ(file.sizeBytes(), 10U);
  EXPECT_EQ(readText(file, 7, 3), "789");
  EXPECT_EQ(readText(file, 0, 2), "01");
  EXPECT_EQ(file.storedBytesRead(), 5U);
}

TEST(FileTest, fillsPartsOneAfterTheOther) {
  const TempFolder folder;
  File file(folder.write("f", "0123456789"));
  std::string a(2, ' '), b(3, ' ');
  const std::array<iovec, 2> parts = {{{a.data(), a.size()}, {b.data(), b.size()}}};
  file.read(4, parts);
  EXPECT_EQ(a, "45");
  EXPECT_EQ(b, "678");
}

TEST(FileTest, readSomeStopsAtTheEnd) {
  const TempFolder folder;
  File file(folder.write("f", "0123"));
  std::array<std::byte, 8> out;
  EXPECT_EQ(file.readSome(1, out), 3U);
  EXPECT_EQ(file.readSome(9, out), 0U);
}

TEST(FileTest, aReadPastTheEndSaysWhereAndHowMuch) {
  const TempFolder folder;
  File file(folder.write("f.raw", "0123"));
  const std::string line = errorOf([&] { readText(file, 2, 5); });
  EXPECT_THAT(line, HasSubstr("f.raw: short read at offset 2: 5 bytes wanted, 2 got"));
}

TEST(FileTest, rejectsAFileTruncatedWhileOpen) {
  const TempFolder folder;
  File file(folder.write("f.raw", "0123456789"));
  std::filesystem::resize_file(folder / "f.raw", 4);
  EXPECT_THAT(errorOf([&] { readText(file, 0, 10); }), HasSubstr("10 bytes wanted, 4 got"));
  EXPECT_THAT(errorOf([&] { readText(file, 0, 2); }), HasSubstr("10 bytes then, 4 now"));
}

TEST(FileTest, rejectsAFileRewrittenWhileOpen) {
  const TempFolder folder;
  File file(folder.write("f.raw", "0123456789"));
  const std::array<timespec, 2> later = {{{0, UTIME_NOW}, {1'900'000'000, 17}}};
  ASSERT_EQ(utimensat(AT_FDCWD, (folder / "f.raw").c_str(), later.data(), 0), 0);
  EXPECT_THAT(errorOf([&] { readText(file, 0, 2); }), HasSubstr("changed while it was open"));
}

TEST(FileTest, rejectsAFileReplacedBetweenReads) {
  const TempFolder folder;
  File file(folder.write("f.raw", "0123456789"), File::Keep::kClosed);
  EXPECT_EQ(readText(file, 0, 2), "01");
  folder.write("other", "abcdefghij");
  std::filesystem::rename(folder / "other", folder / "f.raw");
  EXPECT_THAT(errorOf([&] { readText(file, 0, 2); }), HasSubstr("changed while it was open"));
}

// Sets the time that `cp -p` and tar restore.
void setModified(const std::filesystem::path& path, const timespec& time) {
  const std::array<timespec, 2> times = {{{0, UTIME_OMIT}, time}};
  ASSERT_EQ(utimensat(AT_FDCWD, path.c_str(), times.data(), 0), 0);
}

TEST(FileTest, identityChangesWithAFileOfTheSameSizeAndModificationTime) {
  const TempFolder folder;
  const timespec time{1'700'000'000, 5};
  setModified(folder.write("f", "0123"), time);
  const std::string first = File(folder / "f").identity();
  // A change in place shows in the change time.
  setModified(folder.write("f", "0124"), time);
  const std::string rewritten = File(folder / "f").identity();
  EXPECT_NE(rewritten, first);
  // Another file in its place shows in the inode, too.
  setModified(folder.write("g", "0124"), time);
  std::filesystem::rename(folder / "g", folder / "f");
  EXPECT_NE(File(folder / "f").identity(), rewritten);
}

TEST(FileTest, identityHasAChecksumOfPagesFromTheFirstToTheLast) {
  const TempFolder folder;
  const auto checksum = [&](const std::string& bytes, int pages = File::kSampledPages) {
    const std::string identity = File(folder.write("f", bytes)).identity(pages);
    return identity.substr(identity.rfind('|') + 1);
  };
  std::string bytes(100'000, 'a');
  const std::string first = checksum(bytes);
  EXPECT_EQ(checksum(bytes), first);
  for (const size_t at : {size_t{0}, size_t{50}, bytes.size() - 1}) {
    std::string changed = bytes;
    changed[at] = 'b';
    EXPECT_NE(checksum(changed), first) << at;
    EXPECT_EQ(checksum(changed, 0), checksum(bytes, 0)) << at;
  }
  EXPECT_NE(checksum("ab"), checksum("ac"));
  EXPECT_EQ(checksum("").size(), 16U);
}

TEST(FileTest, identityChangesWithSizeAndTime) {
  const TempFolder folder;
  const std::string first = File(folder.write("f", "01")).identity();
  EXPECT_THAT(first, testing::StartsWith(folder.path().string() + "/f|2|"));
  EXPECT_EQ(first, File(folder / "f").identity());
  const std::array<timespec, 2> later = {{{0, UTIME_NOW}, {1'900'000'000, 17}}};
  ASSERT_EQ(utimensat(AT_FDCWD, (folder / "f").c_str(), later.data(), 0), 0);
  EXPECT_THAT(File(folder / "f").identity(),
              testing::StartsWith(folder.path().string() + "/f|2|1900000000000000017|"));
}

TEST(FileTest, rejectsWhatIsNoRegularFile) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { File file(folder / "none"); }), HasSubstr("No such file"));
  EXPECT_THAT(errorOf([&] { File file(folder.path()); }), HasSubstr("is a folder"));
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(errorOf([&] { File file(folder / "pipe"); }), HasSubstr("no regular file"));
}

}  // namespace
}  // namespace sluice

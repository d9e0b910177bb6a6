#include "src/base/files/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <set>
#include <thread>

#include "src/base/error.h"
#include "tests/support/error_of.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/temp_folder.h"

namespace {

bool& cuttingFails() {
  thread_local bool fails = false;
  return fails;
}

}  // namespace

// Takes the place of the C library's function in this program.
extern "C" int ftruncate(int file, off_t bytes) noexcept {
  if (!cuttingFails()) return static_cast<int>(syscall(SYS_ftruncate, file, bytes));
  errno = EINVAL;
  return -1;
}

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::set<std::string> filesIn(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.insert(entry.path().filename().string());
  return names;
}

TEST(AtomicFile, committedFileHoldsWhatWasWritten) {
  const TempFolder folder;
  const auto path = folder / "out.txt";
  AtomicFile file(path);
  file.write(std::string_view("one "));
  file.write(std::string_view("two"));
  EXPECT_FALSE(std::filesystem::exists(path));
  file.commit();
  EXPECT_EQ(readFile(path), "one two");
  EXPECT_EQ(filesIn(folder.path()), (std::set<std::string>{"out.txt"}));
}

TEST(AtomicFile, abandonedFileLeavesNothing) {
  const TempFolder folder;
  try {
    AtomicFile file(folder / "out.txt");
    file.write(std::string_view("half"));
    throw std::runtime_error("interrupted");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(filesIn(folder.path()), std::set<std::string>());
}

TEST(AtomicFile, takesOverWhatAKilledProcessLeft) {
  const TempFolder folder;
  const auto path = folder / "out.txt";
  writeFile(folder / "out.txt.0.tmp", "left behind by a process that was killed");
  AtomicFile file(path);
  EXPECT_EQ(file.temporaryPath(), folder / "out.txt.0.tmp");
  file.write(std::string_view("new"));
  AtomicFile beside(path);
  EXPECT_EQ(beside.temporaryPath(), folder / "out.txt.1.tmp") << "the first is being written";
  file.commit();
  EXPECT_EQ(readFile(path), "new");
}

// The name while it is written is longer than the file's own, which may be the longest there is.
TEST(AtomicFile, aNameMayBeAsLongAsTheFileSystemAllows) {
  const TempFolder folder;
  constexpr size_t kLongest = 255;
  for (size_t length : {kLongest - 8, kLongest - 5, kLongest}) {
    const auto path = folder / (std::string(length - 4, 'a') + ".txt");
    const auto other = folder / (std::string(length - 5, 'a') + "b.txt");
    AtomicFile file(path), of_other(other), beside(path);
    EXPECT_NE(file.temporaryPath(), of_other.temporaryPath());
    EXPECT_NE(file.temporaryPath(), beside.temporaryPath());
    file.write(std::string_view("new"));
    file.commit();
    EXPECT_EQ(readFile(path), "new");
  }
  // The characters have two bytes, and one of them begins where the name is cut.
  for (const char* first : {"", "a"}) {
    std::string name = first;
    while (name.size() + 2 <= kLongest) name += "\u00e9";
    AtomicFile file(folder / name);
    const std::string temporary = file.temporaryPath().filename().string();
    const std::string kept = temporary.substr(0, temporary.find('~'));
    EXPECT_EQ(kept, name.substr(0, kept.size()));
    EXPECT_EQ((kept.size() - std::string(first).size()) % 2, 0U) << temporary;
  }
}

// Said before the work that the file is for: the temporary name has a length that is allowed.
TEST(AtomicFile, aNameThatIsTooLongIsAnErrorAtOnce) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { AtomicFile(folder / std::string(256, 'a')); }),
              HasSubstr("cannot be written: File name too long"));
  EXPECT_EQ(filesIn(folder.path()), std::set<std::string>());
}

// Files of some file systems cannot be cut.
TEST(AtomicFile, aNewFileIsNotCut) {
  const TempFolder folder;
  cuttingFails() = true;
  EXPECT_NO_THROW(AtomicFile(folder / "out.txt"));
  cuttingFails() = false;
  EXPECT_EQ(filesIn(folder.path()), std::set<std::string>());
}

// The system takes the path up to the zero for the whole, which is another file.
TEST(AtomicFile, aNameWithAZeroByteIsRefused) {
  const TempFolder folder;
  const std::string name("out\0.png", 8);
  EXPECT_THAT(errorOf([&] { AtomicFile(folder / name); }), HasSubstr("zero byte"));
  EXPECT_EQ(filesIn(folder.path()), std::set<std::string>());
}

TEST(AtomicFile, neverWritesThroughALinkThatLiesInItsWay) {
  const TempFolder folder;
  writeFile(folder / "victim", "untouched");
  std::filesystem::create_symlink("victim", folder / "out.txt.0.tmp");
  std::filesystem::create_hard_link(folder / "victim", folder / "out.txt.1.tmp");
  AtomicFile file(folder / "out.txt");
  file.write(std::string_view("new"));
  file.commit();
  EXPECT_EQ(readFile(folder / "out.txt"), "new");
  EXPECT_EQ(readFile(folder / "victim"), "untouched");
}

TEST(AtomicFile, aPipeThatNobodyReadsIsAnError) {
  const TempFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THROW(AtomicFile(folder / "pipe"), Error);
}

TEST(AtomicFile, oldFileStaysUntilTheCommit) {
  const TempFolder folder;
  const auto path = folder / "out.txt";
  writeFile(path, "old");
  { AtomicFile(path).write(std::string_view("abandoned")); }
  EXPECT_EQ(readFile(path), "old");
  AtomicFile file(path);
  file.write(std::string_view("new"));
  EXPECT_EQ(readFile(path), "old");
  file.commit();
  EXPECT_EQ(readFile(path), "new");
}

TEST(AtomicFile, aLibraryMayWriteToTheTemporaryName) {
  const TempFolder folder;
  const auto path = folder / "out.txt";
  AtomicFile file(path);
  EXPECT_EQ(file.temporaryPath().parent_path(), path.parent_path());
  writeFile(file.temporaryPath(), "by another hand");
  file.commit();
  EXPECT_EQ(readFile(path), "by another hand");
}

TEST(AtomicFile, missingFolderIsNamed) {
  const TempFolder folder;
  const auto path = folder / "none" / "out.txt";
  EXPECT_THAT(errorOf([&] { AtomicFile file(path); }),
              AllOf(HasSubstr(path.string()), HasSubstr("No such file")));
}

TEST(AtomicFile, aFolderIsNoFile) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { AtomicFile file(folder.path()); }),
              AllOf(HasSubstr(folder.path().string()), HasSubstr("is a folder")));
}

// Root may write anywhere: while this object lives, the process runs as another user.
class NotRoot {
 public:
  NotRoot() {
    constexpr uid_t kNobody = 65534;
    if (user_ == 0) {
      EXPECT_EQ(seteuid(kNobody), 0);
    }
  }
  ~NotRoot() { EXPECT_EQ(seteuid(user_), 0); }
  NotRoot(const NotRoot&) = delete;
  NotRoot& operator=(const NotRoot&) = delete;

 private:
  const uid_t user_ = geteuid();
};

TEST(AtomicFile, folderThatCannotBeWrittenIsNamed) {
  const TempFolder folder;
  using std::filesystem::perms;
  std::filesystem::permissions(folder.path(), perms::owner_read | perms::owner_exec |
                                                  perms::others_read | perms::others_exec);
  const NotRoot not_root;
  EXPECT_THAT(errorOf([&] { AtomicFile file(folder / "out.txt"); }), HasSubstr("Permission"));
}

TEST(AtomicFile, aFullDiskIsAnErrorAndLeavesTheOldFile) {
  const TempFolder folder;
  const auto path = folder / "out.txt";
  writeFile(path, "old");
  const std::string line = errorOf([&] {
    const FileSizeLimit full(4096);
    AtomicFile file(path);
    file.write(std::string(10000, 'x'));
    file.commit();
  });
  EXPECT_THAT(line, AllOf(HasSubstr(path.string()), HasSubstr("write failed")));
  EXPECT_EQ(readFile(path), "old");
  EXPECT_EQ(filesIn(folder.path()), (std::set<std::string>{"out.txt"}));
}

TEST(AtomicFile, severalOfOnePathDoNotMix) {
  const TempFolder folder;
  const auto path = folder / "out.txt";
  std::vector<std::thread> writers;
  for (int writer = 0; writer < 8; ++writer)
    writers.emplace_back([&path, writer] {
      for (int round = 0; round < 20; ++round) {
        AtomicFile file(path);
        for (int piece = 0; piece < 10; ++piece)
          file.write(std::string(100, static_cast<char>('a' + writer)));
        file.commit();
      }
    });
  for (std::thread& writer : writers) writer.join();
  const std::string found = readFile(path);
  EXPECT_EQ(found, std::string(1000, found.empty() ? '?' : found[0]));
  EXPECT_EQ(filesIn(folder.path()), (std::set<std::string>{"out.txt"}));
}

TEST(AtomicFile, leftoversOfAKilledProcessAreNoObstacle) {
  const TempFolder folder;
  const auto path = folder / "out.txt";
  std::filesystem::path wanted;
  { wanted = AtomicFile(path).temporaryPath(); }
  writeFile(wanted, "left behind");
  AtomicFile file(path);
  file.write(std::string_view("fresh"));
  file.commit();
  EXPECT_EQ(readFile(path), "fresh");
  EXPECT_FALSE(std::filesystem::exists(wanted)) << "it is taken over";
}

TEST(AtomicFile, aSymbolicLinkStaysOne) {
  const TempFolder folder;
  writeFile(folder / "real.txt", "old");
  const auto link = folder / "link.txt";
  std::filesystem::create_symlink("real.txt", link);
  AtomicFile file(link);
  file.write(std::string_view("new"));
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(readFile(folder / "real.txt"), "new");
}

TEST(AtomicFile, aLinkToNothingMakesTheFileItNames) {
  const TempFolder folder;
  const auto link = folder / "link.txt";
  std::filesystem::create_symlink("real.txt", link);
  AtomicFile file(link);
  file.write(std::string_view("new"));
  file.commit();
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(readFile(folder / "real.txt"), "new");
}

TEST(AtomicFile, aDeviceIsWrittenToAndNotReplaced) {
  {
    AtomicFile file("/dev/null");
    EXPECT_EQ(file.temporaryPath(), "/dev/null");
    file.write(std::string_view("gone"));
    file.commit();
  }
  { const AtomicFile abandoned("/dev/null"); }
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(AtomicFile, aPipeGetsTheBytes) {
  const TempFolder folder;
  const auto path = folder / "pipe";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = readFile(path); });
  {
    AtomicFile file(path);
    file.write(std::string_view("through the pipe"));
    file.commit();
  }
  reader.join();
  EXPECT_EQ(got, "through the pipe");
  EXPECT_TRUE(std::filesystem::is_fifo(path));
}

TEST(AtomicFile, permissionsFollowTheUmask) {
  const TempFolder folder;
  const mode_t before = umask(027);
  AtomicFile file(folder / "out.txt");
  file.commit();
  umask(before);
  struct stat status {};
  ASSERT_EQ(stat((folder / "out.txt").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U);
}

}  // namespace
}  // namespace sluice

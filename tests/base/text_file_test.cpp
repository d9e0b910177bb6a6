#include "src/base/files/text_file.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>
#include <thread>

#include "src/base/error.h"
#include "tests/support/error_of.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::HasSubstr;

class TextFile : public testing::Test {
 protected:
  std::string makePipe() const {
    const std::string path = (folder_ / "pipe").string();
    EXPECT_EQ(mkfifo(path.c_str(), 0600), 0);
    return path;
  }
  std::string errorOfReading(const std::filesystem::path& path) const {
    return errorOf([&] { readTextFile(path, 1000, "a look"); });
  }

  const TempFolder folder_;
};

TEST_F(TextFile, isReadWhole) {
  writeFile(folder_ / "a", "two\nlines\n");
  EXPECT_EQ(readTextFile(folder_ / "a", 1000, "a look"), "two\nlines\n");
  writeFile(folder_ / "empty", "");
  EXPECT_EQ(readTextFile(folder_ / "empty", 1000, "a look"), "");
}

TEST_F(TextFile, mayBeAPipeWhoseWriterComesLate) {
  const std::string path = makePipe();
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    std::ofstream(path) << "late";
  });
  EXPECT_EQ(readTextFile(path, 1000, "a look"), "late");
  writer.join();
}

// It read as an empty text, which the error that followed was about.
TEST_F(TextFile, isNoPipeWithoutAWriter) {
  const std::string path = makePipe();
  EXPECT_EQ(errorOfReading(path),
            path + ": expected a look, found a pipe into which nobody writes");
  StopSource stop;
  stop.requestStop();
  EXPECT_THROW(readTextFile(path, 1000, "a look", stop.token()), Interrupted);
}

TEST_F(TextFile, isNoFolderNorDeviceNorCircleOfLinks) {
  EXPECT_THAT(errorOfReading(folder_.path()), HasSubstr("found a folder"));
  EXPECT_EQ(errorOfReading("/dev/zero"),
            "/dev/zero: expected a look of at most 1000 B, found more");
  std::filesystem::create_symlink("b", folder_ / "a");
  std::filesystem::create_symlink("a", folder_ / "b");
  EXPECT_THAT(errorOfReading(folder_ / "a"), HasSubstr("Too many levels of symbolic links"));
}

}  // namespace
}  // namespace sluice

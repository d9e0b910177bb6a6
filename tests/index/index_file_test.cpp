#include "src/index/index_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <random>
#include <thread>

#include "src/base/error.h"
#include "tests/support/temp_folder.h"

namespace sluice::index_file_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::byte> randomBlob(size_t bytes, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<std::byte> blob(bytes);
  for (std::byte& b : blob) b = static_cast<std::byte>(random());
  return blob;
}

class IndexFile : public testing::Test {
 protected:
  std::filesystem::path write(std::span<const std::byte> blob) {
    const IndexWritten written = writeIndex(places_, key_, blob);
    EXPECT_THAT(written.note, IsEmpty());
    return written.path;
  }

  const TempFolder folder_;
  const IndexPlaces places_{folder_ / "beside", {folder_ / "beside", folder_ / "cache"}, false};
  const IndexKey key_{"/data/head.raw 1234 5678", "minmax-32", 3};
};

TEST_F(IndexFile, givesBackWhatWasWritten) {
  EXPECT_EQ(readIndex(places_, key_).state, IndexState::kMissing);
  for (const size_t bytes : {size_t{0}, size_t{1}, size_t{1} << 20}) {
    const auto blob = randomBlob(bytes);
    const auto path = write(blob);
    EXPECT_EQ(path, folder_ / "beside" / "minmax-32.idx");
    const IndexRead read = readIndex(places_, key_);
    EXPECT_EQ(read.state, IndexState::kFound);
    EXPECT_EQ(read.blob, blob);
    EXPECT_EQ(read.path, path);
    EXPECT_THAT(read.note, IsEmpty());
  }
}

TEST_F(IndexFile, cutShortAnywhereIsTorn) {
  const auto path = write(randomBlob(1000));
  const std::string whole = readFile(path);
  for (size_t sixteenth = 0; sixteenth < 16; ++sixteenth) {
    writeFile(path, std::string_view(whole).substr(0, whole.size() * sixteenth / 16));
    const IndexRead read = readIndex(places_, key_);
    EXPECT_EQ(read.state, IndexState::kTorn) << sixteenth;
    EXPECT_FALSE(read.blob.has_value());
    EXPECT_THAT(read.note, HasSubstr(path.string()));
  }
  writeFile(path, std::string_view(whole).substr(0, whole.size() - 1));
  EXPECT_EQ(readIndex(places_, key_).state, IndexState::kTorn);
  writeFile(path, whole + "x");
  EXPECT_EQ(readIndex(places_, key_).state, IndexState::kTorn);
  // The right length, but with zeros at the end, as a crash of the machine leaves them.
  for (size_t sixteenth = 0; sixteenth < 16; ++sixteenth) {
    std::string zeroed = whole;
    std::fill(zeroed.begin() + static_cast<std::ptrdiff_t>(whole.size() * sixteenth / 16),
              zeroed.end(), '\0');
    writeFile(path, zeroed);
    EXPECT_EQ(readIndex(places_, key_).state, IndexState::kTorn) << sixteenth;
  }
}

TEST_F(IndexFile, oneFlippedBitAnywhereIsRefused) {
  const auto path = write(randomBlob(100));
  const std::string whole = readFile(path);
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](size_t at, int byte) {
    file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(byte)).flush();
  };
  for (size_t bit = 0; bit < whole.size() * 8; ++bit) {
    put(bit / 8, whole[bit / 8] ^ (1 << bit % 8));
    const IndexRead read = readIndex(places_, key_);
    ASSERT_FALSE(read.blob.has_value()) << "bit " << bit;
    ASSERT_THAT(read.note, Not(IsEmpty())) << "bit " << bit;
    put(bit / 8, whole[bit / 8]);
  }
  EXPECT_TRUE(readIndex(places_, key_).blob.has_value());
}

TEST_F(IndexFile, anotherKeyIsStale) {
  write(randomBlob(100));
  IndexKey other = key_;
  other.version = 4;
  EXPECT_EQ(readIndex(places_, other).state, IndexState::kStale);
  other = key_;
  other.identity = "/data/head.raw 1234 5679";
  EXPECT_EQ(readIndex(places_, other).state, IndexState::kStale);
  EXPECT_THAT(readIndex(places_, other).note, HasSubstr("minmax-32.idx"));
  // The same letters divided otherwise between identity and what.
  other = key_;
  other.identity.pop_back();
  EXPECT_FALSE(readIndex(places_, other).blob.has_value());
  other = key_;
  other.what = "minmax-16";
  EXPECT_EQ(readIndex(places_, other).state, IndexState::kMissing);
  // The stale one gives way.
  other = key_;
  other.version = 4;
  const auto blob = randomBlob(50, 2);
  writeIndex(places_, other, blob);
  EXPECT_EQ(readIndex(places_, other).blob, blob);
  EXPECT_EQ(readIndex(places_, key_).state, IndexState::kStale);
}

TEST_F(IndexFile, whatMayBeAnyText) {
  const auto blob = randomBlob(10), other = randomBlob(10, 2);
  IndexKey key = key_;
  for (const char* what : {"", "../../escape", ".hidden", "grid name/density", "a\nb"}) {
    key.what = what;
    const IndexWritten written = writeIndex(places_, key, blob);
    EXPECT_EQ(written.path.parent_path(), folder_ / "beside") << what;
    EXPECT_EQ(readIndex(places_, key).blob, blob) << what;
  }
  key.what = "a/b";
  writeIndex(places_, key, blob);
  key.what = "a:b";
  writeIndex(places_, key, other);
  EXPECT_EQ(readIndex(places_, key).blob, other);
  key.what = "a/b";
  EXPECT_EQ(readIndex(places_, key).blob, blob);
}

TEST_F(IndexFile, aFolderThatTakesNothingIsSaidInOneShortLine) {
  writeFile(folder_ / "beside", "a file where the folder should be");
  const IndexWritten written = writeIndex(places_, key_, randomBlob(100));
  EXPECT_THAT(written.path.string(), IsEmpty());
  EXPECT_THAT(written.note, HasSubstr((folder_ / "beside").string()));
  EXPECT_THAT(written.note, HasSubstr("--index-dir"));
  EXPECT_THAT(written.note, Not(HasSubstr("\n")));
  EXPECT_FALSE(readIndex(places_, key_).blob.has_value());
}

TEST_F(IndexFile, aFolderThatRefusesTheFileIsLeftAsItWas) {
  // A folder stands where the file should go: renaming onto it fails at the very end.
  std::filesystem::create_directories(folder_ / "beside" / "minmax-32.idx" / "x");
  const IndexWritten written = writeIndex(places_, key_, randomBlob(100));
  EXPECT_THAT(written.path.string(), IsEmpty());
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "beside"))
    EXPECT_EQ(entry.path().filename(), "minmax-32.idx") << "nothing half-written stays";
}

TEST_F(IndexFile, tornFileInTheFirstPlaceDoesNotHideTheSecond) {
  const auto blob = randomBlob(100);
  writeIndex({folder_ / "cache", {}, false}, key_, blob);
  std::filesystem::create_directory(folder_ / "beside");
  writeFile(folder_ / "beside" / "minmax-32.idx", "rubbish");
  const IndexRead read = readIndex(places_, key_);
  EXPECT_EQ(read.blob, blob);
  EXPECT_EQ(read.path, folder_ / "cache" / "minmax-32.idx");
}

TEST_F(IndexFile, pipesAndFoldersAreNotIndices) {
  std::filesystem::create_directory(folder_ / "beside");
  ASSERT_EQ(mkfifo((folder_ / "beside" / "minmax-32.idx").c_str(), 0600), 0);
  EXPECT_EQ(readIndex(places_, key_).state, IndexState::kTorn);
}

// A volume with a long name has no index beside it, of which a warning told that it cannot be read.
TEST_F(IndexFile, aNameThatIsTooLongIsMissing) {
  const IndexPlaces places =
      indexPlaces((folder_.path() / std::string(250, 'v')).string(), {.folder = folder_.path()});
  const IndexRead read = readIndex(places, key_);
  EXPECT_EQ(read.state, IndexState::kMissing);
  EXPECT_EQ(read.note, "");
}

TEST_F(IndexFile, hostileLengthsAllocateNothing) {
  const auto path = write(randomBlob(10));
  std::string bytes = readFile(path);
  for (const size_t at : {size_t{16}, size_t{20}, size_t{24}}) {  // the three lengths
    std::string hostile = bytes;
    hostile.replace(at, 4, "\xff\xff\xff\xff");
    if (at == 24) hostile.replace(28, 4, "\xff\xff\xff\x7f");
    writeFile(path, hostile);
    EXPECT_EQ(readIndex(places_, key_).state, IndexState::kTorn) << at;
  }
}

// Processes and threads write two different blobs under one key; whoever reads meets one of them
// whole, or none before the first is there, never a mixture.
TEST_F(IndexFile, writersAtTheSameTimeNeverMix) {
  const auto a = randomBlob(200000, 1), b = randomBlob(300000, 2);
  std::vector<pid_t> children;
  for (int child = 0; child < 4; ++child) {
    const pid_t pid = fork();
    ASSERT_GE(pid, 0);
    if (pid == 0) {
      bool fine = true;
      for (int i = 0; i < 20; ++i) {
        fine = fine && !writeIndex(places_, key_, child % 2 == 0 ? a : b).path.empty();
        const IndexRead read = readIndex(places_, key_);
        fine = fine && (read.blob == a || read.blob == b);
      }
      _exit(fine ? 0 : 1);
    }
    children.push_back(pid);
  }
  std::thread writer([&] {
    for (int i = 0; i < 20; ++i) EXPECT_THAT(writeIndex(places_, key_, a).note, IsEmpty());
  });
  for (int i = 0; i < 20; ++i) {
    EXPECT_THAT(writeIndex(places_, key_, b).note, IsEmpty());
    const IndexRead read = readIndex(places_, key_);
    EXPECT_TRUE(read.blob == a || read.blob == b) << name(read.state) << ' ' << read.note;
  }
  writer.join();
  for (const pid_t pid : children) {
    int status = 0;
    waitpid(pid, &status, 0);
    EXPECT_EQ(status, 0);
  }
  const auto files = std::filesystem::directory_iterator(folder_ / "beside");
  EXPECT_EQ(std::distance(begin(files), end(files)), 1) << "no temporary file is left";
}

TEST(IndexPlaces, inTheFolderAndReadBesideTheVolumeToo) {
  const IndexWish wish{.folder = "/caches"};
  const IndexPlaces places = indexPlaces("/data/x/../head.raw", wish);
  ASSERT_EQ(places.folders.size(), 2U);
  EXPECT_THAT(places.folders[0].string(), testing::MatchesRegex("/caches/head\\.raw-[0-9a-f]+"));
  EXPECT_EQ(places.written, places.folders[0]);
  EXPECT_EQ(places.folders[1], "/data/head.raw.sluice-index");
  EXPECT_EQ(indexPlaces("/data/head.raw", wish).folders, places.folders);
  EXPECT_EQ(indexPlaces("/data/slices/", wish).folders[1], "/data/slices.sluice-index");
  EXPECT_EQ(indexPlaces("head.raw", wish).folders[1],
            (std::filesystem::current_path() / "head.raw").string() + ".sluice-index");
  EXPECT_NE(indexPlaces("/other/head.raw", wish).folders[0], places.folders[0]);
  EXPECT_THAT(indexPlaces("/d/a.raw", {.folder = "here"}).written.string(),
              testing::StartsWith((std::filesystem::current_path() / "here").string()));
}

TEST(IndexPlaces, besideTheVolumeWhereThatIsWished) {
  const IndexPlaces places = indexPlaces("/d/a.raw", {.folder = "/caches", .beside = true});
  EXPECT_EQ(places.written, "/d/a.raw.sluice-index");
  ASSERT_EQ(places.folders.size(), 2U);
  EXPECT_EQ(places.folders[0], places.written);
}

TEST(IndexPlaces, withoutAFolderThatBesideTheVolumeIsReadAlone) {
  EXPECT_EQ(indexPlaces("/d/a.raw", {}).folders.size(), 1U);
  EXPECT_THAT(indexPlaces("/d/a.raw", {}).written.string(), IsEmpty());
  EXPECT_THAT(indexPlaces("synth:cube", {}).folders, IsEmpty());
  EXPECT_THAT(writeIndex(indexPlaces("synth:cube", {}), {"i", "w", 1}, {}).note, HasSubstr("HOME"));
}

TEST(IndexPlaces, userMayDisableThem) {
  const IndexPlaces places = indexPlaces("/d/a.raw", {.folder = "/caches", .disabled = true});
  EXPECT_TRUE(places.disabled);
  EXPECT_EQ(readIndex(places, {"i", "w", 1}).state, IndexState::kDisabled);
  EXPECT_THAT(writeIndex(places, {"i", "w", 1}, {}).note, HasSubstr("SLUICE_INDEX"));
}

TEST(IndexPlaces, syntheticVolumesHaveTheFolderAlone) {
  const IndexPlaces places =
      indexPlaces("synth:phantom,dims=512x512x512", {.folder = "/caches", .beside = true});
  ASSERT_EQ(places.folders.size(), 1U);
  EXPECT_THAT(places.folders[0].string(), testing::StartsWith("/caches/synth"));
  EXPECT_EQ(places.written, places.folders[0]);
}

}  // namespace
}  // namespace sluice::index_file_test

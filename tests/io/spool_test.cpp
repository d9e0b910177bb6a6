#include "io/spool.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <thread>

#include "src/base/interrupt.h"
#include "tests/io/volume_files.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// zlib's own gzip writer; level 0 stores, which makes positions inside predictable.
std::string gzipped(const std::string& bytes, const TempFolder& folder, const char* mode = "wb6") {
  const auto path = folder / "gzipped.tmp";
  gzFile file = gzopen(path.c_str(), mode);
  gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(file);
  return readFile(path);
}

std::string zlibbed(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size,
           reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  out.resize(size);
  return out;
}

// Bytes that deflate cannot shrink, so that a stream has many blocks.
std::string noise(size_t count) {
  std::string bytes(count, '\0');
  uint32_t state = 1;
  for (char& c : bytes) c = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
  return bytes;
}

std::unique_ptr<Spool> spoolOf(const std::filesystem::path& path, uint64_t offset, uint64_t skip,
                               uint64_t keep, Codec codec = Codec::kDeflate) {
  std::vector<EncodedFile> inputs = {{std::make_shared<File>(path), offset, skip, keep}};
  return std::make_unique<Spool>(inputs, codec, VoxelType::kU8, "2 x 3 = 6 bytes");
}

std::string readText(Spool& spool, uint64_t offset, size_t length) {
  std::string text(length, '\0');
  const iovec part{text.data(), text.size()};
  spool.read(offset, std::span(&part, 1));
  return text;
}

// Sets TMPDIR for the time of a test.
class TemporaryFolderAt {
 public:
  explicit TemporaryFolderAt(const std::string& folder) {
    if (const char* const old = std::getenv("TMPDIR")) old_ = old;
    setenv("TMPDIR", folder.c_str(), 1);
  }
  ~TemporaryFolderAt() {
    if (old_)
      setenv("TMPDIR", old_->c_str(), 1);
    else
      unsetenv("TMPDIR");
  }

 private:
  std::optional<std::string> old_;
};

TEST(SpoolTest, decodesGzipAndZlibFromAnOffset) {
  const TempFolder folder;
  const std::string voxels = noise(3'000'000);
  const std::string front = "header";
  for (const std::string& stream : {gzipped(voxels, folder), zlibbed(voxels)}) {
    const auto spool = spoolOf(folder.write("f", front + stream), front.size(), 0, voxels.size());
    EXPECT_TRUE(readText(*spool, 0, voxels.size()) == voxels);
    EXPECT_TRUE(readText(*spool, 2'999'990, 10) == voxels.substr(2'999'990));
  }
}

TEST(SpoolTest, skipsDecodedBytes) {
  const TempFolder folder;
  const std::string voxels = noise(2'500'000);
  const auto spool =
      spoolOf(folder.write("f", gzipped(voxels, folder)), 0, 1'500'001, 2'500'000 - 1'500'001);
  EXPECT_TRUE(readText(*spool, 0, 999'999) == voxels.substr(1'500'001));
}

TEST(SpoolTest, membersOfGzipThatFollowOneAnotherAreOneStream) {
  const TempFolder folder;
  // Members of many sizes, so that boundaries meet the ends of the input buffer.
  std::string voxels, stream;
  for (size_t i = 0; i < 60; ++i) {
    const std::string part = noise(20'000 + 97 * i);
    voxels += part;
    stream += gzipped(part, folder);
  }
  const auto spool =
      spoolOf(folder.write("f", stream + std::string(512, '\0')), 0, 0, voxels.size());
  EXPECT_TRUE(readText(*spool, 0, voxels.size()) == voxels);
}

TEST(SpoolTest, severalFilesFollowOneAnother) {
  const TempFolder folder;
  std::vector<EncodedFile> inputs;
  for (const char* text : {"abc", "def"}) {
    const auto path = folder.write(text, gzipped(text, folder));
    inputs.push_back({std::make_shared<File>(path), 0, 1, 2});
  }
  Spool spool(inputs, Codec::kDeflate, VoxelType::kU8, "");
  EXPECT_EQ(readText(spool, 0, 4), "bcef");
}

TEST(SpoolTest, decodesOnceAndCountsCompressedBytes) {
  const TempFolder folder;
  const std::string voxels(1'000'000, 'a');
  const std::string stream = gzipped(voxels, folder);
  const auto spool = spoolOf(folder.write("f", stream), 0, 0, voxels.size());
  EXPECT_EQ(spool->storedBytesRead(), 0U);  // nothing is decoded before it is needed
  std::vector<std::jthread> threads;
  threads.reserve(4);
  std::atomic<int> wrong{0};
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] { wrong += readText(*spool, 5, 999'995) != voxels.substr(5); });
  threads.clear();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(spool->storedBytesRead(), stream.size());
}

TEST(SpoolTest, leavesNoFileBehind) {
  const TempFolder folder, spools;
  const TemporaryFolderAt here(spools.path());
  const auto spool = spoolOf(folder.write("f", gzipped("abcdef", folder)), 0, 0, 6);
  EXPECT_EQ(readText(*spool, 0, 6), "abcdef");
  EXPECT_TRUE(std::filesystem::is_empty(spools.path()));
}

TEST(SpoolTest, aStreamOfAnotherLengthShowsTheArithmetic) {
  const TempFolder folder;
  const auto path = folder.write("v.gz", gzipped("abcdef", folder));
  EXPECT_THAT(errorOf([&] { readText(*spoolOf(path, 0, 0, 7), 0, 1); }),
              HasSubstr("v.gz: 2 x 3 = 6 bytes expected, 6 found"));
  EXPECT_THAT(errorOf([&] { readText(*spoolOf(path, 0, 0, 5), 0, 1); }),
              HasSubstr("v.gz: 2 x 3 = 6 bytes expected, the stream goes on after them"));
  EXPECT_THAT(errorOf([&] { readText(*spoolOf(path, 0, 9, 5), 0, 1); }), HasSubstr("6 found"));
}

TEST(SpoolTest, everyTruncationOfAStreamIsAnError) {
  const TempFolder folder;
  const std::string stream = gzipped(noise(300), folder);
  for (size_t length = 0; length < stream.size(); ++length) {
    const auto path = folder.write("t", stream.substr(0, length));
    errorOf([&] { readText(*spoolOf(path, 0, 0, 300), 0, 1); });
  }
  const auto path = folder.write("t", stream.substr(0, 200));
  EXPECT_THAT(errorOf([&] { readText(*spoolOf(path, 0, 0, 300), 0, 1); }),
              HasSubstr("found before the compressed stream breaks off"));
  folder.write("t", stream.substr(0, stream.size() - 1));
  EXPECT_THAT(errorOf([&] { readText(*spoolOf(path, 0, 0, 300), 0, 1); }),
              HasSubstr("before its checksum"));
}

TEST(SpoolTest, aDamagedStreamIsAnError) {
  const TempFolder folder;
  std::string stream = gzipped("abcdefghij", folder, "wb0");
  stream[stream.size() - 10] ^= 1;  // the last stored byte; 8 bytes of checksum and length follow
  EXPECT_THAT(errorOf([&] { readText(*spoolOf(folder.write("f", stream), 0, 0, 10), 0, 1); }),
              HasSubstr("damaged"));
  EXPECT_THAT(errorOf([&] { readText(*spoolOf(folder.write("f", "no gzip"), 0, 0, 10), 0, 1); }),
              HasSubstr("damaged"));
}

TEST(SpoolTest, aTinyStreamThatClaimsMuchIsTurnedAwayAtOnce) {
  const TempFolder folder;
  const auto path = folder.write("f", gzipped("abc", folder));
  EXPECT_THAT(errorOf([&] { spoolOf(path, 0, 0, uint64_t{1} << 40); }),
              HasSubstr("bytes of encoded data can hold"));
  EXPECT_THAT(errorOf([&] { spoolOf(path, 0, uint64_t{1} << 60, 3); }), HasSubstr("can hold"));
  EXPECT_THAT(errorOf([&] { spoolOf(path, 1000, 0, 1); }), HasSubstr("the 0 bytes"));
}

TEST(SpoolTest, aBombIsNotWrittenBeyondWhatWasDeclared) {
  const TempFolder folder;
  const auto path = folder.write("f", gzipped(std::string(8'000'000, '\0'), folder));
  const auto spool = spoolOf(path, 0, 0, 1000);
  EXPECT_THAT(errorOf([&] { readText(*spool, 0, 1); }), HasSubstr("goes on after them"));
  EXPECT_LE(spool->storedBytesRead(), File(path).sizeBytes());
}

TEST(SpoolTest, aFailureIsRememberedAndNotDecodedAgain) {
  const TempFolder folder;
  const auto spool = spoolOf(folder.write("f", gzipped("abcdef", folder)), 0, 0, 7);
  const std::string first = errorOf([&] { readText(*spool, 0, 1); });
  const uint64_t read_bytes = spool->storedBytesRead();
  EXPECT_EQ(errorOf([&] { readText(*spool, 0, 1); }), first);
  EXPECT_EQ(spool->storedBytesRead(), read_bytes);
}

TEST(SpoolTest, aTemporaryFolderThatIsMissingSaysWhatToSet) {
  const TempFolder folder;
  const TemporaryFolderAt nowhere((folder / "none").string());
  const auto spool = spoolOf(folder.write("f", gzipped("abcdef", folder)), 0, 0, 6);
  EXPECT_THAT(errorOf([&] { readText(*spool, 0, 1); }), HasSubstr("set TMPDIR"));
}

TEST(SpoolTest, aFullDiskSaysWhatToSet) {
  const TempFolder folder;
  const std::string voxels(3'000'000, 'a');
  const auto spool = spoolOf(folder.write("f", gzipped(voxels, folder)), 0, 0, voxels.size());
  // A limit on file sizes stands in for a full disk: the write fails half way.
  rlimit old = {};
  getrlimit(RLIMIT_FSIZE, &old);
  const rlimit small{2'000'000, old.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string line = errorOf([&] { readText(*spool, 0, 1); });
  setrlimit(RLIMIT_FSIZE, &old);
  signal(SIGXFSZ, handler);
  EXPECT_THAT(line, HasSubstr("set TMPDIR to a folder with room"));
}

TEST(SpoolTest, anInterruptionUnwindsAndLeavesNothing) {
  // The child is this very process: one that starts over has folders of its own.
  GTEST_FLAG_SET(death_test_style, "fast");
  const TempFolder folder, spools;
  const TemporaryFolderAt here(spools.path());
  const auto path = folder.write("f", gzipped("abcdef", folder));
  const auto interrupted = [&] {
    watchForInterruption();
    raise(SIGINT);
    try {
      readText(*spoolOf(path, 0, 0, 6), 0, 1);
    } catch (const Interrupted&) {
      std::_Exit(130);  // unwound; what follows at exit is not the matter
    }
  };
  EXPECT_EXIT(interrupted(), testing::ExitedWithCode(130), "");
  EXPECT_TRUE(std::filesystem::is_empty(spools.path()));
}

TEST(SpoolTest, readsNumbersWrittenAsText) {
  const TempFolder folder;
  std::string text = "# skipped\n", voxels;
  for (int i = 0; i < 60'000; ++i) {
    text += std::to_string(i % 256) + (i % 7 == 0 ? "\r\n" : i % 3 == 0 ? ", " : "\t");
    voxels += static_cast<char>(i % 256);
  }
  const auto spool = spoolOf(folder.write("f", text), 10, 0, voxels.size(), Codec::kText);
  EXPECT_TRUE(readText(*spool, 0, voxels.size()) == voxels);
}

TEST(SpoolTest, rejectsTextThatIsNoValueOfTheType) {
  const TempFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"1 2 x", "'x'"},   {"1 2 256", "'256'"},   {"1 -2 3", "'-2'"},  {"1 2.5 3", "'2.5'"},
      {"1 2", "2 found"}, {"1 2 3 4", "goes on"}, {"1 2 0x3", "'0x3'"}};
  for (const auto& [text, expected] : cases) {
    const auto path = folder.write("f", std::string(text) + std::string(10, ' '));
    EXPECT_THAT(errorOf([&] { readText(*spoolOf(path, 0, 0, 3, Codec::kText), 0, 1); }),
                HasSubstr(expected))
        << text;
  }
  const auto path = folder.write("f", std::string(100'000, '1'));
  EXPECT_THAT(errorOf([&] { readText(*spoolOf(path, 0, 0, 3, Codec::kText), 0, 1); }),
              HasSubstr("is no u8"));
}

}  // namespace
}  // namespace sluice

#include "io/headers/decoded_file.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <thread>

#include "src/base/threads/stop_token.h"
#include "tests/io/headers/volume_files.h"
#include "tests/support/file_size_limit.h"

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

std::unique_ptr<DecodedFile> decodedFileOf(const std::filesystem::path& path, uint64_t offset,
                                           uint64_t skip, uint64_t keep,
                                           Codec codec = Codec::kDeflate,
                                           const DecodeOptions& options = {}) {
  std::vector<EncodedFile> inputs = {{std::make_shared<File>(path), offset, skip, keep}};
  return std::make_unique<DecodedFile>(inputs, codec, VoxelType::kU8, "2 x 3 = 6 bytes", options);
}

std::string readText(DecodedFile& decoded, uint64_t offset, size_t length) {
  std::string text(length, '\0');
  const iovec part{text.data(), text.size()};
  decoded.read(offset, std::span(&part, 1));
  return text;
}

TEST(DecodedFileTest, decodesGzipAndZlibFromAnOffset) {
  const TempFolder folder;
  const std::string voxels = noise(3'000'000);
  const std::string front = "header";
  for (const std::string& stream : {gzipped(voxels, folder), zlibbed(voxels)}) {
    const auto decoded =
        decodedFileOf(folder.write("f", front + stream), front.size(), 0, voxels.size());
    EXPECT_TRUE(readText(*decoded, 0, voxels.size()) == voxels);
    EXPECT_TRUE(readText(*decoded, 2'999'990, 10) == voxels.substr(2'999'990));
  }
}

TEST(DecodedFileTest, skipsDecodedBytes) {
  const TempFolder folder;
  const std::string voxels = noise(2'500'000);
  const auto decoded = decodedFileOf(folder.write("f", gzipped(voxels, folder)), 0, 1'500'001,
                                     2'500'000 - 1'500'001);
  EXPECT_TRUE(readText(*decoded, 0, 999'999) == voxels.substr(1'500'001));
}

TEST(DecodedFileTest, membersOfGzipThatFollowOneAnotherAreOneStream) {
  const TempFolder folder;
  // Members of many sizes, so that boundaries meet the ends of the input buffer.
  std::string voxels, stream;
  for (size_t i = 0; i < 60; ++i) {
    const std::string part = noise(20'000 + 97 * i);
    voxels += part;
    stream += gzipped(part, folder);
  }
  const auto decoded =
      decodedFileOf(folder.write("f", stream + std::string(512, '\0')), 0, 0, voxels.size());
  EXPECT_TRUE(readText(*decoded, 0, voxels.size()) == voxels);
}

TEST(DecodedFileTest, severalFilesFollowOneAnother) {
  const TempFolder folder;
  std::vector<EncodedFile> inputs;
  for (const char* text : {"abc", "def"}) {
    const auto path = folder.write(text, gzipped(text, folder));
    inputs.push_back({std::make_shared<File>(path), 0, 1, 2});
  }
  DecodedFile decoded(inputs, Codec::kDeflate, VoxelType::kU8, "");
  EXPECT_EQ(readText(decoded, 0, 4), "bcef");
}

TEST(DecodedFileTest, decodesOnceAndCountsCompressedBytes) {
  const TempFolder folder;
  const std::string voxels(1'000'000, 'a');
  const std::string stream = gzipped(voxels, folder);
  const auto decoded = decodedFileOf(folder.write("f", stream), 0, 0, voxels.size());
  EXPECT_EQ(decoded->storedBytesRead(), 0U);  // nothing is decoded before it is needed
  std::vector<std::jthread> threads;
  threads.reserve(4);
  std::atomic<int> wrong{0};
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] { wrong += readText(*decoded, 5, 999'995) != voxels.substr(5); });
  threads.clear();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(decoded->storedBytesRead(), stream.size());
}

TEST(DecodedFileTest, leavesNoFileBehind) {
  const TempFolder folder, temporaries;
  const auto decoded = decodedFileOf(folder.write("f", gzipped("abcdef", folder)), 0, 0, 6,
                                     Codec::kDeflate, {.folder = temporaries.path()});
  EXPECT_EQ(readText(*decoded, 0, 6), "abcdef");
  EXPECT_TRUE(std::filesystem::is_empty(temporaries.path()));
}

TEST(DecodedFileTest, aStreamOfAnotherLengthShowsTheArithmetic) {
  const TempFolder folder;
  const auto path = folder.write("v.gz", gzipped("abcdef", folder));
  EXPECT_THAT(errorOf([&] { readText(*decodedFileOf(path, 0, 0, 7), 0, 1); }),
              HasSubstr("v.gz: 2 x 3 = 6 bytes expected, 6 found"));
  EXPECT_THAT(errorOf([&] { readText(*decodedFileOf(path, 0, 0, 5), 0, 1); }),
              HasSubstr("v.gz: 2 x 3 = 6 bytes expected, the stream goes on after them"));
  EXPECT_THAT(errorOf([&] { readText(*decodedFileOf(path, 0, 9, 5), 0, 1); }),
              HasSubstr("6 found"));
}

TEST(DecodedFileTest, everyTruncationOfAStreamIsAnError) {
  const TempFolder folder;
  const std::string stream = gzipped(noise(300), folder);
  for (size_t length = 0; length < stream.size(); ++length) {
    const auto path = folder.write("t", stream.substr(0, length));
    errorOf([&] { readText(*decodedFileOf(path, 0, 0, 300), 0, 1); });
  }
  const auto path = folder.write("t", stream.substr(0, 200));
  EXPECT_THAT(errorOf([&] { readText(*decodedFileOf(path, 0, 0, 300), 0, 1); }),
              HasSubstr("found before the compressed stream breaks off"));
  folder.write("t", stream.substr(0, stream.size() - 1));
  EXPECT_THAT(errorOf([&] { readText(*decodedFileOf(path, 0, 0, 300), 0, 1); }),
              HasSubstr("before its checksum"));
}

TEST(DecodedFileTest, aDamagedStreamIsAnError) {
  const TempFolder folder;
  std::string stream = gzipped("abcdefghij", folder, "wb0");
  stream[stream.size() - 10] ^= 1;  // the last stored byte; 8 bytes of checksum and length follow
  EXPECT_THAT(errorOf([&] { readText(*decodedFileOf(folder.write("f", stream), 0, 0, 10), 0, 1); }),
              HasSubstr("damaged"));
  EXPECT_THAT(
      errorOf([&] { readText(*decodedFileOf(folder.write("f", "no gzip"), 0, 0, 10), 0, 1); }),
      HasSubstr("damaged"));
}

TEST(DecodedFileTest, aTinyStreamThatClaimsMuchIsTurnedAwayAtOnce) {
  const TempFolder folder;
  const auto path = folder.write("f", gzipped("abc", folder));
  EXPECT_THAT(errorOf([&] { decodedFileOf(path, 0, 0, uint64_t{1} << 40); }),
              HasSubstr("bytes of encoded data can hold"));
  EXPECT_THAT(errorOf([&] { decodedFileOf(path, 0, uint64_t{1} << 60, 3); }),
              HasSubstr("can hold"));
  EXPECT_THAT(errorOf([&] { decodedFileOf(path, 1000, 0, 1); }), HasSubstr("the 0 bytes"));
}

TEST(DecodedFileTest, aBombIsNotWrittenBeyondWhatWasDeclared) {
  const TempFolder folder;
  const auto path = folder.write("f", gzipped(std::string(8'000'000, '\0'), folder));
  const auto decoded = decodedFileOf(path, 0, 0, 1000);
  EXPECT_THAT(errorOf([&] { readText(*decoded, 0, 1); }), HasSubstr("goes on after them"));
  EXPECT_LE(decoded->storedBytesRead(), File(path).sizeBytes());
}

TEST(DecodedFileTest, aFailureIsRememberedAndNotDecodedAgain) {
  const TempFolder folder;
  const auto decoded = decodedFileOf(folder.write("f", gzipped("abcdef", folder)), 0, 0, 7);
  const std::string first = errorOf([&] { readText(*decoded, 0, 1); });
  const uint64_t read_bytes = decoded->storedBytesRead();
  EXPECT_EQ(errorOf([&] { readText(*decoded, 0, 1); }), first);
  EXPECT_EQ(decoded->storedBytesRead(), read_bytes);
}

TEST(DecodedFileTest, tellsWhoWatchesOfEachByte) {
  const TempFolder folder;
  const std::string voxels = noise(3'000'000);
  const auto path = folder.write("f", gzipped(voxels, folder));
  std::vector<uint64_t> told;
  std::string of;
  DecodeOptions options;
  options.watch = [&](const std::string& file) {
    of = file;
    return [&](uint64_t done, uint64_t total) {
      told.push_back(done);
      EXPECT_EQ(total, voxels.size());
    };
  };
  const auto decoded = decodedFileOf(path, 0, 0, voxels.size(), Codec::kDeflate, options);
  EXPECT_EQ(readText(*decoded, 0, 6), voxels.substr(0, 6));
  EXPECT_EQ(of, path.string());
  ASSERT_GE(told.size(), 2U);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), voxels.size());
}

TEST(DecodedFileTest, aTemporaryFolderThatIsMissingSaysWhatToSet) {
  const TempFolder folder;
  const auto decoded = decodedFileOf(folder.write("f", gzipped("abcdef", folder)), 0, 0, 6,
                                     Codec::kDeflate, {.folder = folder / "none"});
  EXPECT_THAT(errorOf([&] { readText(*decoded, 0, 1); }), HasSubstr("set TMPDIR"));
}

TEST(DecodedFileTest, aFullDiskSaysWhatToSet) {
  const TempFolder folder;
  const std::string voxels(3'000'000, 'a');
  const auto decoded =
      decodedFileOf(folder.write("f", gzipped(voxels, folder)), 0, 0, voxels.size());
  // The write fails half way.
  const std::string line = errorOf([&] {
    const FileSizeLimit full(2'000'000);
    readText(*decoded, 0, 1);
  });
  EXPECT_THAT(line, HasSubstr("set TMPDIR to a folder with room"));
}

TEST(DecodedFileTest, aStopUnwindsAndLeavesNothing) {
  const TempFolder folder, temporaries;
  StopSource stop;
  const DecodeOptions here{.folder = temporaries.path(), .stop = stop.token()};
  const auto path = folder.write("f", gzipped("abcdef", folder));
  const auto decoded = decodedFileOf(path, 0, 0, 6, Codec::kDeflate, here);
  stop.requestStop();
  EXPECT_THROW(readText(*decoded, 0, 1), Interrupted);
  EXPECT_TRUE(std::filesystem::is_empty(temporaries.path()));
}

TEST(DecodedFileTest, readsNumbersWrittenAsText) {
  const TempFolder folder;
  std::string text = "# skipped\n", voxels;
  for (int i = 0; i < 60'000; ++i) {
    text += std::to_string(i % 256) + (i % 7 == 0 ? "\r\n" : i % 3 == 0 ? ", " : "\t");
    voxels += static_cast<char>(i % 256);
  }
  const auto decoded = decodedFileOf(folder.write("f", text), 10, 0, voxels.size(), Codec::kText);
  EXPECT_TRUE(readText(*decoded, 0, voxels.size()) == voxels);
}

TEST(DecodedFileTest, rejectsTextThatIsNoValueOfTheType) {
  const TempFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"1 2 x", "'x'"},   {"1 2 256", "'256'"},   {"1 -2 3", "'-2'"},  {"1 2.5 3", "'2.5'"},
      {"1 2", "2 found"}, {"1 2 3 4", "goes on"}, {"1 2 0x3", "'0x3'"}};
  for (const auto& [text, expected] : cases) {
    const auto path = folder.write("f", std::string(text) + std::string(10, ' '));
    EXPECT_THAT(errorOf([&] { readText(*decodedFileOf(path, 0, 0, 3, Codec::kText), 0, 1); }),
                HasSubstr(expected))
        << text;
  }
  const auto path = folder.write("f", std::string(100'000, '1'));
  EXPECT_THAT(errorOf([&] { readText(*decodedFileOf(path, 0, 0, 3, Codec::kText), 0, 1); }),
              HasSubstr("is no u8"));
}

}  // namespace
}  // namespace sluice

#include "cache/trace/decompressed_file.h"

#include <gmock/gmock.h>
#include <zlib.h>
#include <zstd.h>

#include <functional>

#include "cache/policies/random.h"
#include "tests/cache/trace/trace_files.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::HasSubstr;

std::string gzipped(const std::string& content) {
  z_stream stream = {};
  constexpr int kGzip = 15 + 16;
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(deflateBound(&stream, content.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string zstandard(const std::string& content) {
  std::string out(ZSTD_compressBound(content.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), content.data(), content.size(), 3));
  return out;
}

// More than the buffers hold, with sizes and clusters that only our formats keep.
Trace manyRecords() {
  Random random(3);
  Trace trace;
  for (uint32_t i = 0; i < 20'000; ++i) {
    const uint32_t chunk = random.below(5000);
    trace.records.push_back({chunk, 1 + chunk % 3, i / 100, i / 1000, {(1 + chunk % 3) * 4096}});
  }
  return trace;
}

class DecompressedTraces : public TraceFiles {
 protected:
  std::filesystem::path put(const std::string& file, const std::string& content) {
    std::ofstream(folder_ / file, std::ios::binary) << content;
    return folder_ / file;
  }
  Trace readFile(const std::filesystem::path& path) { return readAll(*openTrace(path)); }
};

TEST_F(DecompressedTraces, everyFormatIsReadCompressedAsItIsPlain) {
  const std::pair<TraceFormat, const char*> formats[] = {
      {TraceFormat::kText, "t.txt"},
      {TraceFormat::kBinary, "t.trace"},
      {TraceFormat::kCsv, "t.csv"},
      {TraceFormat::kDin, "t.din"},
      {TraceFormat::kOracleGeneral, "t.oracleGeneral"}};
  for (const auto& [format, file] : formats) {
    const std::string content = contentOf(write(manyRecords(), format, file));
    const Trace plain = readFile(folder_ / file);
    ASSERT_EQ(plain.records.size(), 20'000u);
    for (const std::string& name : {std::string(file) + ".gz", std::string(file) + ".zst"}) {
      const auto packed = put(name, name.ends_with(".gz") ? gzipped(content) : zstandard(content));
      EXPECT_TRUE(isTraceFile(packed)) << name;
      EXPECT_EQ(readFile(packed).records, plain.records) << name;
    }
  }
}

TEST_F(DecompressedTraces, theContentCountsAndNotTheName) {
  const std::string csv = "1,2,3000\n2,3,3000\n3,2,3000\n";
  const Trace plain = read(csv, TraceFormat::kCsv);
  EXPECT_EQ(readFile(put("plain.csv.zst", csv)).records, plain.records);
  EXPECT_EQ(readFile(put("zstd.csv", zstandard(csv))).records, plain.records);
  EXPECT_EQ(readFile(put("gzip.csv.zst", gzipped(csv))).records, plain.records);
}

// A compressed file is a multiple of 24 bytes now and then, and was read as raw records.
TEST_F(DecompressedTraces, aCompressedFileOfWholeRecordsIsNotTakenForRawOnes) {
  const std::string raw =
      contentOf(write(manyRecords(), TraceFormat::kOracleGeneral, "t.oracleGeneral"));
  std::filesystem::remove(folder_ / "t.oracleGeneral.sluice");
  const Trace plain = readFile(folder_ / "t.oracleGeneral");
  std::string packed = zstandard(raw);
  // A skippable frame fills the file up to whole records.
  const size_t payload = (24 - (packed.size() + 8) % 24) % 24;
  packed += std::string("\x50\x2a\x4d\x18", 4) + static_cast<char>(payload) +
            std::string(3 + payload, '\0');
  ASSERT_EQ(packed.size() % 24, 0u);
  EXPECT_EQ(readFile(put("u.oracleGeneral.zst", packed)).records, plain.records);
  EXPECT_THAT(errorOf([&] {
                readAll(*makeTraceReader(std::make_unique<std::istringstream>(packed), "raw",
                                         TraceFormat::kOracleGeneral, 4096));
              }),
              HasSubstr("expected the number of a later request"));
}

TEST_F(DecompressedTraces, whatFollowsAMemberIsReadToo) {
  const std::string one = "1,2,3000\n", two = "2,3,3000\n";
  EXPECT_EQ(readFile(put("t.csv.gz", gzipped(one) + gzipped(two))).records.size(), 2u);
  EXPECT_EQ(readFile(put("t.csv.zst", zstandard(one) + zstandard(two))).records.size(), 2u);
}

// Contents around the buffers' size, at which the end of the output is the end of the file.
TEST_F(DecompressedTraces, sizesAtTheBuffersEndsAreRead) {
  for (const size_t size : {65535u, 65536u, 65537u, 131072u}) {
    std::string csv;
    while (csv.size() + 9 <= size) csv += "1,2,3000\n";
    csv.resize(size, '\n');
    const size_t records = readFile(put("p.csv", csv)).records.size();
    EXPECT_EQ(readFile(put("t.csv.gz", gzipped(csv))).records.size(), records) << size;
    EXPECT_EQ(readFile(put("t.csv.zst", zstandard(csv))).records.size(), records) << size;
  }
}

TEST_F(DecompressedTraces, cutAndDamagedFilesAreNamed) {
  std::string csv;
  Random random(7);
  for (int i = 0; i < 50'000; ++i) csv += fmt::format("{},{},4096\n", i, random.below(9999));
  for (const auto& [name, packed] :
       {std::pair{"t.csv.gz", gzipped(csv)}, std::pair{"t.csv.zst", zstandard(csv)}}) {
    const auto cut = put(name, packed.substr(0, packed.size() / 2));
    EXPECT_THAT(errorOf([&] { readFile(cut); }), testing::AllOf(HasSubstr(name), HasSubstr("cut")));
    std::string wrong = packed;
    for (size_t i = wrong.size() / 2; i < wrong.size() / 2 + 64; ++i) wrong[i] ^= 0x55;
    const auto damaged = put(name, wrong);
    EXPECT_THAT(errorOf([&] { readFile(damaged); }), HasSubstr(name));
    EXPECT_NE(errorOf([&] { readFile(put(name, packed + "more")); }), "");
  }
}

// Neither the name nor the few bytes that can be unpacked tell that it is a trace.
TEST_F(DecompressedTraces, zstandardDataCutInItsFirstBlockAreATrace) {
  const std::string packed = zstandard(std::string(100, 'a') + "no trace");
  const auto cut = put("cut.zst", packed.substr(0, packed.size() / 2));
  EXPECT_TRUE(isTraceFile(cut));
  EXPECT_THAT(errorOf([&] { openTrace(cut); }),
              testing::AllOf(HasSubstr("cut.zst"), HasSubstr("may be cut")));
}

TEST_F(DecompressedTraces, otherCompressionsAreNamed) {
  const auto path = put("t.csv.xz", std::string("\xfd"
                                                "7zXZ\0\0\0",
                                                8));
  EXPECT_TRUE(isTraceFile(path));
  EXPECT_THAT(errorOf([&] { openTrace(path); }), HasSubstr("found xz data; unpack it"));
}

TEST_F(DecompressedTraces, aNameThatPromisesCompressionIsNotWritten) {
  for (const char* name : {"t.csv.zst", "t.gz"})
    EXPECT_THAT(
        errorOf([&] { makeTraceWriter(folder_ / name, traceFormatOf(folder_ / name), 4096); }),
        HasSubstr("compressed traces are read, not written"));
}

}  // namespace
}  // namespace sluice

// Traces written in every format: as others read them, and read back.
#include <gmock/gmock.h>

#include "cache/policies/random.h"
#include "cache/simulate/simulator.h"
#include "cache/trace/prepared_trace.h"
#include "tests/cache/trace/trace_files.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

TEST_F(TraceFiles, oracleGeneralIsLibCacheSimsLayout) {
  Trace trace;
  trace.records = {{0x1122334455667788, 1, 0, 9, {4096, 0, 0, 0}},
                   {3, 2, 0, 10, {8192, 0, 0, 0}},
                   {0x1122334455667788, 1, 0, 11, {4096, 0, 0, 0}}};
  const auto path = write(trace, TraceFormat::kOracleGeneral, "t.oracleGeneral");
  // u32 time, u64 id, u32 size, i64 next: the first is requested again as request 3.
  const std::string first("\x09\0\0\0\x88\x77\x66\x55\x44\x33\x22\x11\0\x10\0\0\x03\0\0\0\0\0\0\0",
                          24);
  const std::string content = contentOf(path);
  ASSERT_EQ(content.size(), 72u);
  EXPECT_EQ(content.substr(0, 24), first);
  EXPECT_EQ(content.substr(40, 8), std::string(8, '\xff'));  // never again
  const Trace back = readAll(*openTrace(path));
  ASSERT_EQ(back.records.size(), 3u);
  EXPECT_EQ(back.records[1].chunk, 3u);
  EXPECT_EQ(back.records[1].pages, 2u);
  EXPECT_EQ(back.records[2].frame, 11u);
}

TEST_F(TraceFiles, csvIsWhatLibCacheSimReads) {
  // Time, id and size in the first three columns, one line of names.
  Trace trace;
  trace.records = {{17, 2, 1, 4, {8192, 5000, 0, 0}}, {18, 1, 2, 5, {4096, 1, 2, 3}, 6}};
  EXPECT_EQ(contentOf(write(trace, TraceFormat::kCsv, "t.csv")),
            "time,obj_id,obj_size,cluster,pages_of_4096_bytes,needed,extended,empty,level,records\n"
            "4,17,8192,1,2,5000,0,0,0,\n"
            "5,18,4096,2,1,1,2,3,6,2\n");
  // Files without levels, as they were once written.
  const Trace older = read(
      "time,obj_id,obj_size,cluster,pages_of_4096_bytes,needed,extended,empty,records\n"
      "4,17,8192,1,2,5000,0,0,\n5,18,4096,2,1,1,2,3,2\n",
      TraceFormat::kCsv);
  trace.records.back().level = 0;
  EXPECT_EQ(older.records, trace.records);
}

TEST_F(TraceFiles, aLevelOfResolutionIsWrittenIfItIsNotTheFinest) {
  Trace trace;
  trace.records = {{900, 1, 0, 0, {4096, 0, 0, 0}}, {17, 1, 5, 0, {4096, 0, 0, 0}, 3}};
  EXPECT_EQ(contentOf(write(trace, TraceFormat::kDin, "t.din")),
            "0 0 sluice-trace 1 page_bytes 4096 900 1 0 0 4096 0 0 0\n"
            "0 1000 17 1 5 0 4096 0 0 0 3 records 2\n");
  EXPECT_THAT(contentOf(write(trace, TraceFormat::kText, "t.txt")),
              testing::HasSubstr("\n900 1 0 0 4096 0 0 0\n17 1 5 0 4096 0 0 0 3\n"));
}

TEST_F(TraceFiles, dinHasALineAPageAndTheRestBehindTheAddress) {
  Trace trace;
  trace.records = {{900, 2, 0, 0, {8192, 0, 0, 0}},
                   {17, 1, 5, 0, {4096, 0, 0, 0}},
                   {900, 2, 0, 1, {8192, 0, 0, 0}}};
  const auto path = write(trace, TraceFormat::kDin, "t.din");
  EXPECT_EQ(contentOf(path),
            "0 0 sluice-trace 1 page_bytes 4096 900 2 0 0 8192 0 0 0\n0 1000\n"
            "0 2000 17 1 5 0 4096 0 0 0\n"
            "0 0 900 2 0 1 8192 0 0 0\n0 1000 records 3\n");
  // Another program's trace has labels and addresses only.
  const Trace pages = read("0 0 a comment\n0 1000\n2 0x2fff\n", TraceFormat::kDin);
  ASSERT_EQ(pages.records.size(), 3u);
  EXPECT_FALSE(pages.carries_clusters);
  EXPECT_EQ(pages.records[2].chunk, 2u);
}

constexpr TraceFormat kAllFormats[] = {TraceFormat::kText, TraceFormat::kBinary, TraceFormat::kCsv,
                                       TraceFormat::kOracleGeneral, TraceFormat::kDin};

// With clusters of several chunks, some of which do not fit a small cache together.
Trace turn() {
  Random random(2);
  Trace trace;
  trace.page_bytes = 16384;
  for (uint32_t i = 0; i < 2000; ++i) {
    const uint64_t chunk = random.below(50);
    const auto pages = static_cast<uint32_t>(1 + chunk % 4);
    const auto level = static_cast<uint32_t>(chunk % 12);
    const uint64_t moved = pages * trace.page_bytes;
    trace.records.push_back(
        {chunk * 77, pages, i / 5 % 9, i / 100, {moved, moved / 2, moved / 4, 100}, level});
  }
  return trace;
}

std::string extensionOf(TraceFormat format) {
  return "t." + std::string(format == TraceFormat::kText ? "txt" : name(format));
}

TEST_F(TraceFiles, everyFormatGivesBackTheRecordsThemselves) {
  for (const Trace& trace : {turn(), Trace{4096, {{3, 1, 2, 1, {4096, 5, 0, 0}}}}}) {
    for (const TraceFormat format : kAllFormats) {
      const auto path = write(trace, format, extensionOf(format));
      // Any page size may be given for a file that does not contain one.
      const Trace back = readAll(*openTrace(path, std::nullopt, 512));
      EXPECT_EQ(back.page_bytes, trace.page_bytes) << name(format);
      EXPECT_TRUE(back.carries_clusters);
      EXPECT_EQ(back.records, trace.records) << name(format);
    }
  }
}

TEST_F(TraceFiles, everyFormatGivesTheNumbersOfTheTraceItself) {
  std::vector<PolicyKind> policies(onlinePolicies().begin(), onlinePolicies().end());
  policies.push_back(PolicyKind::kBelady);
  policies.push_back(PolicyKind::kBeladyPages);
  const std::vector<uint64_t> sizes{4, 7, 20, 40, 90, 200};
  SimulationConfig pinned;
  pinned.pin_clusters = true;
  const std::string rows = toCsv(simulateTable(prepare(turn()), policies, sizes, pinned));
  for (const TraceFormat format : kAllFormats) {
    const PreparedTrace back =
        prepare(readAll(*openTrace(write(turn(), format, extensionOf(format)))));
    EXPECT_EQ(toCsv(simulateTable(back, policies, sizes, pinned)), rows) << name(format);
  }
}

// Refused, without a request, or, if only the first words are left, read with a warning.
bool isRefusedOrSuspect(const std::filesystem::path& path, TraceFormat format) {
  constexpr size_t kFirstWords = 36;
  try {
    const auto reader = openTrace(path, format);
    if (readAll(*reader).records.empty()) return true;
    return !reader->warnings().empty() && std::filesystem::file_size(path) < kFirstWords;
  } catch (const Error&) {
    return true;
  }
}

// A cut anywhere at the end of what we write is noticed.
TEST_F(TraceFiles, everyFormatSaysWhereItWasCut) {
  Trace trace = turn();
  trace.records.resize(12);
  for (const TraceFormat format : kAllFormats) {
    const auto path = write(trace, format, extensionOf(format));
    const std::string good = contentOf(path);
    // The last line's end alone may be missing: nothing is lost then.
    const size_t whole = good.size() - (good.ends_with('\n') ? 1 : 0);
    for (size_t length = 0; length < whole; ++length) {
      std::ofstream(path, std::ios::binary) << good.substr(0, length);
      EXPECT_TRUE(isRefusedOrSuspect(path, format)) << name(format) << ' ' << length;
    }
  }
}

TEST_F(TraceFiles, companionOfAnotherTraceIsRefused) {
  const auto path = write(turn(), TraceFormat::kOracleGeneral, "a.oracleGeneral");
  Trace other = turn();
  other.records[1999].frame = 77;
  write(other, TraceFormat::kOracleGeneral, "b.oracleGeneral");
  std::filesystem::rename(folder_ / "b.oracleGeneral.sluice", folder_ / "a.oracleGeneral.sluice");
  EXPECT_THAT(errorOf([&] { readAll(*openTrace(path)); }),
              testing::HasSubstr("record 2000 is not that of"));
  // Without the companion it is read like another simulator's: ids and sizes, no clusters.
  std::filesystem::remove(folder_ / "a.oracleGeneral.sluice");
  const Trace alone = readAll(*openTrace(path, std::nullopt, 16384));
  EXPECT_FALSE(alone.carries_clusters);
  EXPECT_EQ(alone.records.size(), 2000u);
  EXPECT_EQ(alone.records[7].pages, turn().records[7].pages);
}

TEST_F(TraceFiles, dinRefusesMoreLinesThanAnyoneReads) {
  Trace trace;
  trace.records = {{1, 1u << 31, 0, 0, {4096, 0, 0, 0}}};
  EXPECT_THAT(errorOf([&] { write(trace, TraceFormat::kDin, "t.din"); }),
              testing::HasSubstr("a line a page"));
}

}  // namespace
}  // namespace sluice

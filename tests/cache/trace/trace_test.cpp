#include "cache/trace/trace.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "cache/policies/random.h"
#include "tests/cache/trace/trace_files.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

Trace sample() {
  Trace trace;
  trace.page_bytes = 4096;
  trace.records = {{UINT64_MAX, 1, 0, 0, {4096, 4096, 0, 0}},
                   {0, 64, 0, 0, {262144, 100000, 5000, 7000}},
                   {1, 64, 0, 0, {262144, 100000, 5000, 7000}},
                   {5, 1u << 31, UINT32_MAX, 3, {uint64_t{1} << 40, 0, 0, 0}},
                   {0, 64, 7, UINT32_MAX, {262144, 100000, 5000, 7000}, 63},
                   {0, 64, 7, UINT32_MAX, {262144, 100000, 5000, 7000}, 2}};
  return trace;
}

TEST_F(TraceFiles, ownFormatsKeepEverything) {
  for (const TraceFormat format : {TraceFormat::kText, TraceFormat::kBinary}) {
    const auto path = write(sample(), format, "trace");
    const Trace back = readAll(*openTrace(path));
    EXPECT_EQ(back.page_bytes, 4096u);
    EXPECT_EQ(back.records, sample().records) << name(format);
  }
}

TEST_F(TraceFiles, binaryIsCompactForSequentialChunks) {
  Trace trace;
  for (uint64_t i = 0; i < 10000; ++i)
    trace.records.push_back({i, 64, 0, 0, {262144, 262144, 0, 0}});
  const auto path = write(trace, TraceFormat::kBinary, "trace");
  EXPECT_LT(std::filesystem::file_size(path), 10000 * 2 + 64);
  EXPECT_EQ(readAll(*openTrace(path)).records, trace.records);
}

TEST_F(TraceFiles, csvIsReadWithAndWithoutHeader) {
  for (const char* header : {"", "time,obj_id,obj_size\n", "#time, object, size, next\r\n"}) {
    const Trace trace =
        read(std::string(header) + "1.5, 42, 5000, 3\r\n\n2,43,1\n", TraceFormat::kCsv);
    ASSERT_EQ(trace.records.size(), 2u) << header;
    EXPECT_EQ(trace.records[0].chunk, 42u);
    EXPECT_EQ(trace.records[0].frame, 1u);
    EXPECT_EQ(trace.records[0].pages, 2u);
    EXPECT_EQ(trace.records[0].bytes.needed, 5000u);
    EXPECT_EQ(trace.records[0].bytes.rounding(), 8192u - 5000);
  }
}

// Columns were read by their places, so that sizes became chunks.
TEST(TraceReaders, takeTheColumnsOfACsvFileByTheirNames) {
  for (const char* content :
       {"time,obj_size,obj_id\n1,5000,42\n2,1,43\n", "obj_id,time,obj_size\n42,1,5000\n43,2,1\n",
        "op,Timestamp,\"what, and why\",SIZE,object id\nget,1.5,\"a,b\",5000,42\nset,2,,1,43,x\n",
        "\xef\xbb\xbf\"obj-size\",\"key\",\"clock_time\"\r\n5000,42,1.\r\n1,43,2\r\n"}) {
    SCOPED_TRACE(content);
    const Trace trace = read(content, TraceFormat::kCsv);
    ASSERT_EQ(trace.records.size(), 2u);
    EXPECT_EQ(trace.records[0].chunk, 42u);
    EXPECT_EQ(trace.records[0].frame, 1u);
    EXPECT_EQ(trace.records[0].bytes.needed, 5000u);
    EXPECT_EQ(trace.records[1].chunk, 43u);
    EXPECT_EQ(trace.records[1].frame, 2u);
    EXPECT_EQ(trace.records[1].bytes.needed, 1u);
  }
}

std::vector<std::string> warningsOf(const std::string& content, TraceFormat format) {
  const auto reader =
      makeTraceReader(std::make_unique<std::istringstream>(content), "t", format, 4096);
  readAll(*reader);
  return reader->warnings();
}

TEST(TraceReaders, warnOfOthersFilesThatMayBeCut) {
  using testing::ElementsAre;
  using testing::HasSubstr;
  using testing::IsEmpty;
  const std::string text = "sluice-trace 1 page_bytes 4096\n1 1 0 0 4096 0 0 0";
  EXPECT_THAT(warningsOf(text, TraceFormat::kText), ElementsAre(HasSubstr("t:2: the last line")));
  EXPECT_THAT(warningsOf(text + "\n", TraceFormat::kText), IsEmpty());
  EXPECT_THAT(warningsOf("1,2,3\n1,2,3", TraceFormat::kCsv), ElementsAre(HasSubstr("t:2:")));
  EXPECT_THAT(warningsOf("1,2,3\n1,2,3\n", TraceFormat::kCsv), IsEmpty());
  EXPECT_THAT(warningsOf("0 1\n0 2", TraceFormat::kDin), ElementsAre(HasSubstr("t:2:")));
  std::string record(24, '\0');
  record[16] = 2;  // requested again as request 2
  const std::string last = record.substr(0, 16) + std::string(8, '\xff');
  EXPECT_THAT(warningsOf(record, TraceFormat::kOracleGeneral), ElementsAre(HasSubstr("2")));
  EXPECT_THAT(warningsOf(record + last, TraceFormat::kOracleGeneral), IsEmpty());
}

TEST(TraceReaders, takeTheirNumberOfRecordsWhereverItStands) {
  const std::string head = "sluice-trace 1 page_bytes 4096\n", record = "1 1 0 0 4096 0 0 0\n";
  EXPECT_EQ(read(head + record + "# records 1\n", TraceFormat::kText).records.size(), 1U);
  EXPECT_EQ(read(head + "# records 2\n" + record + record, TraceFormat::kText).records.size(), 2U);
  EXPECT_EQ(read(head + "# records of a turn\n" + record, TraceFormat::kText).records.size(), 1U);
}

struct Hostile {
  TraceFormat format;
  std::string content;
  const char* said;  // part of the error
};

TEST(TraceReaders, rejectBadInputInOneLine) {
  const std::string head = "sluice-trace 1 page_bytes 4096\n";
  const std::string magic("SLTRACE\x01\x80\x20", 10);
  const std::vector<Hostile> cases{
      {TraceFormat::kText, "", "t:1: expected 'sluice-trace 1"},
      {TraceFormat::kText, "sluice-trace 2 page_bytes 4096\n", "t:1:"},
      {TraceFormat::kText, "sluice-trace 1 page_bytes 0\n", "t:1:"},
      {TraceFormat::kText, head + "1 2 3\n", "t:2: expected 8 or 9 whole numbers"},
      {TraceFormat::kText, head + "1 1 0 0 4096 0 0 0 1 9\n", "t:2: expected 8 or 9 whole numbers"},
      {TraceFormat::kText, head + "# ok\n1 1 0 0 4096 0 0 -1\n",
       "t:3: expected 8 or 9 whole numbers"},
      {TraceFormat::kText, head + "1 0 0 0 4096 0 0 0\n", "pages from 1"},
      {TraceFormat::kText, head + "1 4294967297 0 0 4096 0 0 0\n", "pages to 2^31"},
      {TraceFormat::kText, head + "1 1 4294967296 0 4096 0 0 0\n", "cluster and frame"},
      {TraceFormat::kText, head + "1 1 0 0 10 5 5 5\n", "within the bytes moved"},
      {TraceFormat::kText, head + "1 1 0 0 10 18446744073709551615 1 0\n",
       "within the bytes moved"},
      {TraceFormat::kText, head + "1 1 0 0 2199023255552 0 0 0\n", "2^40"},
      {TraceFormat::kText, head + "1 1 0 0 4096 0 0 0 64\n", "levels from 0 to 63"},
      {TraceFormat::kText, head + "1 1 0 0 4096 0 0 0\n# records 2\n",
       "t: expected 2 records, found 1"},
      {TraceFormat::kText, head + "# records 2\n1 1 0 0 4096 0 0 0\n",
       "t: expected 2 records, found 1"},
      {TraceFormat::kBinary, "", "first bytes"},
      {TraceFormat::kBinary, "SLTRACE\x02", "first bytes"},
      {TraceFormat::kBinary, std::string("SLTRACE\x01", 8), "the file ends in the middle"},
      {TraceFormat::kBinary, std::string("SLTRACE\x01\x00", 9), "bytes a page, found 0"},
      {TraceFormat::kBinary, magic, "record 1: the file ends in the middle"},
      {TraceFormat::kBinary, magic + "\x11", "found tag 17"},
      {TraceFormat::kBinary, magic + std::string("\x00\x05", 2), "expected 5 records, found 0"},
      {TraceFormat::kBinary, magic + "\x01" + std::string(11, '\xff'), "below 2^64"},
      {TraceFormat::kBinary, magic + "\x03" + std::string(6, '\0'), "pages from 1"},
      {TraceFormat::kCsv, "time,id,size\n1,x,3\n", "t:2: expected time,obj_id,obj_size"},
      {TraceFormat::kCsv, "1,x,3\n1,2,3\n", "t:1: expected time,obj_id,obj_size"},
      {TraceFormat::kCsv, "x,1,3\n1,2,3\n", "t:1: expected time,obj_id,obj_size"},
      {TraceFormat::kCsv, "1;2;3\n1,2,3\n", "t:1: expected time,obj_id,obj_size"},
      {TraceFormat::kCsv, "time,id\n1,2,3\n", "t:1: expected time,obj_id,obj_size"},
      {TraceFormat::kCsv, "time,block,length\n1,2,3\n",
       "t:1: expected the columns' names time, obj_id and obj_size once each, in any order, found "
       "'time,block,length'"},
      {TraceFormat::kCsv, "time,obj_id,ttl\n1,2,3\n", "t:1: expected the columns' names"},
      {TraceFormat::kCsv, "time,obj_id,obj_size,key\n1,2,3,4\n",
       "found 'time,obj_id,obj_size,key'"},
      {TraceFormat::kCsv, "time,op,obj_size,obj_id\n1,get,3\n",
       "t:2: expected time,...,obj_size,obj_id as whole numbers, found '1,get,3'"},
      {TraceFormat::kCsv, "1,2,-3\n", "t:1: expected time,obj_id,obj_size"},
      {TraceFormat::kCsv, "1,18446744073709551616,3\n", "t:1: expected"},
      {TraceFormat::kCsv,
       std::string("\x7f"
                   "ELF\x02\x01\x01\0\0\n1,2,3\n",
                   15),
       "t:1: expected"},
      {TraceFormat::kCsv, std::string(1 << 20, '1'), "a line of at most"},
      {TraceFormat::kCsv, "time,obj_id,obj_size,cluster,pages_of_x", "t:1: expected"},
      {TraceFormat::kDin, "0 0 sluice-trace 1 page_bytes 0 1 1 1 1 1 1 0 0\n", "t:1: expected"},
      {TraceFormat::kDin, "0 0 sluice-trace 1 page_bytes 4096 1 2 0 0 1 1 0 0\n0 7 records 1\n",
       "t:2: expected"},
      {TraceFormat::kBinary, magic + std::string("\x00\x00z", 3), "found more"},
      {TraceFormat::kCsv, "1,2,3\n1,2\n", "t:2: expected"},
      {TraceFormat::kCsv, "1,2,99999999999999\n", "expected"},
      {TraceFormat::kOracleGeneral, std::string(25, 'x'), "record 2: expected 24 bytes, found 1"},
      {TraceFormat::kDin, "5 100\n", "label 0 to 2"},
      {TraceFormat::kDin, "0 zz\n", "hexadecimal"},
      {TraceFormat::kDin, "0\n", "hexadecimal"},
  };
  for (const Hostile& c : cases) {
    try {
      read(c.content, c.format);
      ADD_FAILURE() << name(c.format) << ": no error for " << c.content;
    } catch (const Error& e) {
      const std::string line = e.what();
      EXPECT_NE(line.find(c.said), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
  }
}

TEST_F(TraceFiles, aPipeIsRefusedAndNotWaitedFor) {
  const auto path = folder_ / "pipe.csv";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_THAT(errorOf([&] { openTrace(path); }), testing::HasSubstr("found a pipe"));
}

TEST_F(TraceFiles, namesAFileItDoesNotKnow) {
  std::ofstream(folder_ / "what.xyz") << "hello, this is no trace";
  EXPECT_THROW(openTrace(folder_ / "what.xyz"), Error);
  EXPECT_THROW(openTrace(folder_ / "missing"), Error);
  EXPECT_THROW(openTrace(folder_), Error);
}

// Volumes end with .bin, too.
TEST_F(TraceFiles, aBinIsATraceIfItBeginsAsOracleGeneral) {
  Trace trace;
  for (const uint64_t chunk : {1, 2, 1}) trace.records.push_back({chunk, 1, 0, 0, {4096, 4096}});
  const auto path = write(trace, TraceFormat::kOracleGeneral, "t.oracleGeneral");
  std::filesystem::copy_file(path, folder_ / "t.bin");
  EXPECT_TRUE(isTraceFile(folder_ / "t.bin"));
  EXPECT_EQ(readAll(*openTrace(folder_ / "t.bin")).records.size(), 3U);
  std::ofstream(folder_ / "empty.bin");
  std::ofstream(folder_ / "zeros.bin") << std::string(240, '\0');
  std::ofstream(folder_ / "voxels.bin") << std::string(240, '\x07');
  std::ofstream(folder_ / "short.bin") << contentOf(path).substr(0, 23);
  for (const char* name : {"empty.bin", "zeros.bin", "voxels.bin", "short.bin"})
    EXPECT_FALSE(isTraceFile(folder_ / name)) << name;
}

// Whatever the bytes, a reader gives records within its promises or one Error.
TEST(TraceReaders, surviveRandomBytes) {
  const std::string starts[] = {"sluice-trace 1 page_bytes 4096\n",
                                std::string("SLTRACE\x01\x80\x20", 10), "time,obj_id,obj_size\n",
                                "", "0 10\n"};
  const TraceFormat formats[] = {TraceFormat::kText, TraceFormat::kBinary, TraceFormat::kCsv,
                                 TraceFormat::kOracleGeneral, TraceFormat::kDin};
  int errors = 0, records = 0;
  for (uint64_t seed = 0; seed < 4000; ++seed) {
    Random random(seed * 1000);
    const size_t which = seed % 5;
    std::string content = starts[which];
    const uint32_t length = random.below(200);
    // Every other file is made of bytes that parse further than even ones do.
    const std::string likely = which == 1 ? std::string("\x01\x03\x05\x07\x00\x02\x80", 7)
                                          : std::string("0123456789 ,.\nx#-");
    for (uint32_t i = 0; i < length; ++i)
      content += seed % 2 == 0 ? static_cast<char>(random.below(256))
                               : likely[random.below(likely.size())];
    try {
      const Trace trace = read(content, formats[which]);
      for (const TraceRecord& r : trace.records) {
        ++records;
        ASSERT_GE(r.pages, 1u);
        ASSERT_LE(r.bytes.needed + r.bytes.extended + r.bytes.empty, r.bytes.moved);
      }
    } catch (const Error& e) {
      ++errors;
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(errors, 0);
  EXPECT_GT(records, 0);
}

// Every single byte of a good binary file changed or cut off.
TEST_F(TraceFiles, damagedBinaryFilesNeverPassPromises) {
  const std::string good = contentOf(write(sample(), TraceFormat::kBinary, "good"));
  for (size_t cut = 0; cut < good.size(); ++cut)
    EXPECT_THROW(read(good.substr(0, cut), TraceFormat::kBinary), Error) << cut;
  for (size_t at = 0; at < good.size(); ++at) {
    for (const int flip : {1, 0x10, 0x80, 0xff}) {
      std::string bad = good;
      bad[at] = static_cast<char>(bad[at] ^ flip);
      try {
        for (const TraceRecord& r : read(bad, TraceFormat::kBinary).records)
          EXPECT_LE(r.bytes.needed, r.bytes.moved);
      } catch (const Error&) {  // refusing is fine too
      }
    }
  }
}

}  // namespace
}  // namespace sluice

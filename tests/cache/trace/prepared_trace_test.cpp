#include "cache/trace/prepared_trace.h"

#include <gmock/gmock.h>

#include "tests/support/error_of.h"

namespace sluice {
namespace {

TEST(PreparedTrace, sharesOfBytesAddUp) {
  const LoadBytes whole{100003, 50001, 7, 40000};
  LoadBytes sum;
  for (uint64_t part = 0; part < 13; ++part) {
    const LoadBytes share = shareOf(whole, part, 13);
    sum.moved += share.moved;
    sum.needed += share.needed;
    sum.extended += share.extended;
    sum.empty += share.empty;
  }
  EXPECT_EQ(sum, whole);
}

TEST(PreparedTrace, refusesMoreBytesThanCanBeCounted) {
  Trace trace;
  trace.page_bytes = uint64_t{1} << 40;
  trace.records = {{1, 1u << 31, 0, 0, {0, 0, 0, 0}}};
  EXPECT_THAT(errorOf([&] { prepare(trace); }), testing::HasSubstr("2^63 bytes or more"));
}

TEST(PreparedTrace, knowsFramesAndIds) {
  Trace trace;
  trace.records = {{9, 1, 2, 0, {}}, {5, 2, 2, 0, {}}, {9, 1, 2, 1, {}}, {9, 1, 3, 1, {}}};
  const PreparedTrace prepared = prepare(trace);
  EXPECT_THAT(prepared.ids, testing::ElementsAre(9, 5));
  EXPECT_EQ(prepared.frame_begins, (std::vector<uint32_t>{0, 2}));
  EXPECT_THAT(prepared.visits, testing::ElementsAre(0, 0, 1, 2));
  const PreparedTrace pages = splitIntoPages(prepared);
  EXPECT_THAT(pages.ids, testing::ElementsAre(9, 5, 5));
  EXPECT_EQ(pages.frame_begins, (std::vector<uint32_t>{0, 3}));
  trace.carries_clusters = false;
  EXPECT_TRUE(prepare(trace).visits.empty());
  EXPECT_TRUE(prepare(trace).frame_begins.empty());
}

TEST(PreparedTrace, countsRecordsWhoseSizeChanged) {
  Trace trace;
  trace.records = {{1, 2, 0, 0, {}}, {1, 3, 0, 0, {}}, {2, 1, 1, 0, {}}};
  const PreparedTrace prepared = prepare(trace);
  EXPECT_EQ(prepared.resized, 1u);
  EXPECT_EQ(prepared.page_requests, 2u + 2 + 1);
  EXPECT_THAT(prepared.visits, testing::ElementsAre(0, 0, 1));
}

}  // namespace
}  // namespace sluice

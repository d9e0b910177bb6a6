// The binary format: the differences between records, in varints.
#include <algorithm>

#include "cache/trace/trace_formats.h"

namespace sluice::trace_internal {
namespace {

// Leads a record or the end.
enum : uint8_t { kEnd = 0, kRecord = 1, kSameVisit = 2, kSameShape = 4, kNewLevel = 8 };

class BinaryReader final : public Reader {
 public:
  BinaryReader(Stream in, std::string label) : Reader(std::move(in), std::move(label), 0) {
    if (in_.bytes(kBinaryMagic.size()) != kBinaryMagic)
      fail("{}: expected a binary trace of version 1, found other first bytes", in_.label());
    page_bytes_ = varint();
    if (page_bytes_ < 1 || page_bytes_ > kMaxBytes)
      fail("{}: expected 1 to 2^40 bytes a page, found {}", in_.label(), page_bytes_);
  }

  bool next(TraceRecord& record) override {
    if (ended_) return false;
    const uint8_t tag = byte();
    if (tag == kEnd) {
      readEnd();
      return false;
    }
    if ((tag & kRecord) == 0 || tag > (kRecord | kSameVisit | kSameShape | kNewLevel))
      fail("{}: record {}: expected a record or the end, found tag {}", in_.label(), records_ + 1,
           tag);
    // Differences wrap as unsigned numbers do, which is what the writer counts on.
    last_.chunk += unzigzag(varint());
    if ((tag & kSameVisit) == 0) {
      last_.cluster += static_cast<uint32_t>(unzigzag(varint()));
      last_.frame += static_cast<uint32_t>(unzigzag(varint()));
    }
    if ((tag & kSameShape) == 0) {
      const uint64_t pages = varint();
      last_.bytes.moved = varint();
      last_.bytes.needed = varint();
      last_.bytes.extended = varint();
      last_.bytes.empty = varint();
      last_.pages = static_cast<uint32_t>(std::min<uint64_t>(pages, UINT32_MAX));
    }
    if ((tag & kNewLevel) != 0)
      last_.level = static_cast<uint32_t>(std::min<uint64_t>(varint(), UINT32_MAX));
    // A shape that repeats was checked when it came.
    if ((tag & (kSameShape | kNewLevel)) != kSameShape) {
      if (const char* problem = problemOf(last_))
        fail(
            "{}: record {}: expected {}, found pages {} moved {} needed {} extended {} empty {} "
            "level {}",
            in_.label(), records_ + 1, problem, last_.pages, last_.bytes.moved, last_.bytes.needed,
            last_.bytes.extended, last_.bytes.empty, last_.level);
    }
    ++records_;
    record = last_;
    return true;
  }

 private:
  uint8_t byte() {
    const int c = in_.byte();
    if (c < 0)
      fail("{}: record {}: the file ends in the middle; record the trace again", in_.label(),
           records_ + 1);
    return static_cast<uint8_t>(c);
  }
  uint64_t varint() {
    uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const uint8_t b = byte();
      // The tenth byte has room for one bit of 64.
      if (shift == 63 && b > 1) break;
      value |= static_cast<uint64_t>(b & 127u) << shift;
      if (b < 128) return value;
    }
    fail("{}: record {}: expected a number below 2^64, found a longer one", in_.label(),
         records_ + 1);
  }
  static uint64_t unzigzag(uint64_t v) { return (v >> 1) ^ (~(v & 1) + 1); }
  void readEnd() {
    checkPromised(varint());
    if (in_.byte() >= 0)
      fail("{}: expected the end of the file after {} records, found more; record the trace again",
           in_.label(), records_);
    ended_ = true;
  }

  bool ended_ = false;
  TraceRecord last_;
};

class BinaryWriter final : public Writer {
 public:
  BinaryWriter(const std::filesystem::path& path, uint64_t page_bytes) : Writer(path, page_bytes) {
    out_.append(kBinaryMagic);
    putVarint(page_bytes);
    out_.append(bytes_);
  }
  void write(const TraceRecord& r) override {
    const bool same_visit = r.cluster == last_.cluster && r.frame == last_.frame;
    // The reader begins with an empty shape, which is none.
    const bool same_shape = r.pages == last_.pages && r.bytes == last_.bytes && records_ > 0;
    const bool new_level = r.level != last_.level;
    bytes_.assign(1,
                  static_cast<char>(kRecord | (same_visit ? kSameVisit : 0) |
                                    (same_shape ? kSameShape : 0) | (new_level ? kNewLevel : 0)));
    putVarint(zigzag(r.chunk - last_.chunk));
    if (!same_visit) {
      putVarint(zigzag(uint64_t{r.cluster} - last_.cluster));
      putVarint(zigzag(uint64_t{r.frame} - last_.frame));
    }
    if (!same_shape) {
      putVarint(r.pages);
      putVarint(r.bytes.moved);
      putVarint(r.bytes.needed);
      putVarint(r.bytes.extended);
      putVarint(r.bytes.empty);
    }
    if (new_level) putVarint(r.level);
    out_.append(bytes_);
    last_ = r;
    ++records_;
  }
  void finish() override {
    bytes_.assign(1, static_cast<char>(kEnd));
    putVarint(records_);
    out_.append(bytes_);
    Writer::finish();
  }

 private:
  void putVarint(uint64_t value) {
    for (; value >= 128; value >>= 7) bytes_ += static_cast<char>(value | 128);
    bytes_ += static_cast<char>(value);
  }
  // A difference as a signed number, small ones of either sign in few bits.
  static uint64_t zigzag(uint64_t difference) {
    return (difference << 1) ^ (difference >> 63 != 0 ? ~uint64_t{0} : 0);
  }

  std::string bytes_;
  TraceRecord last_;
};

}  // namespace

std::unique_ptr<TraceReader> makeBinaryReader(Stream in, std::string label) {
  return std::make_unique<BinaryReader>(std::move(in), std::move(label));
}
std::unique_ptr<TraceWriter> makeBinaryWriter(const std::filesystem::path& path,
                                              uint64_t page_bytes) {
  return std::make_unique<BinaryWriter>(path, page_bytes);
}

}  // namespace sluice::trace_internal

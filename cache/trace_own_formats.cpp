// Readers of the text and binary formats.
#include <algorithm>
#include <array>
#include <utility>

#include "cache/trace_formats.h"

namespace sluice::trace_internal {
namespace {

class TextReader final : public TraceReader {
 public:
  TextReader(std::unique_ptr<std::istream> in, std::string label)
      : in_(std::move(in)), label_(std::move(label)) {
    std::string line;
    std::getline(*in_, line);
    std::string_view rest = line;
    if (rest.ends_with('\r')) rest.remove_suffix(1);
    if (!rest.starts_with(kTextMagic) ||
        !parseNumber(rest.substr(kTextMagic.size()), page_bytes_) || page_bytes_ < 1 ||
        page_bytes_ > kMaxBytes)
      fail("{}:1: expected '{}N', found {}; is it a trace?", label_, kTextMagic, excerpt(line));
  }

  bool next(TraceRecord& record) override {
    std::string line;
    while (std::getline(*in_, line)) {
      ++line_number_;
      if (line.ends_with('\r')) line.pop_back();
      if (line.empty() || line.front() == '#') continue;
      parse(line, record);
      return true;
    }
    return false;
  }
  uint64_t pageBytes() const override { return page_bytes_; }

 private:
  void parse(std::string_view line, TraceRecord& record) const {
    std::array<uint64_t, 8> v{};
    std::string_view rest = line;
    for (size_t field = 0; field < v.size(); ++field) {
      const size_t end = field + 1 < v.size() ? rest.find(' ') : rest.size();
      if (end == std::string_view::npos || !parseNumber(rest.substr(0, end), v[field]))
        fail("{}:{}: expected 8 whole numbers with single spaces, found {}", label_, line_number_,
             excerpt(line));
      rest.remove_prefix(std::min(rest.size(), end + 1));
    }
    if (v[1] > kMaxPages || v[2] > UINT32_MAX || v[3] > UINT32_MAX)
      fail("{}:{}: expected pages to 2^31, cluster and frame to 2^32 - 1, found {}", label_,
           line_number_, excerpt(line));
    record = {v[0],
              static_cast<uint32_t>(v[1]),
              static_cast<uint32_t>(v[2]),
              static_cast<uint32_t>(v[3]),
              {v[4], v[5], v[6], v[7]}};
    if (const char* problem = problemOf(record))
      fail("{}:{}: expected {}, found {}", label_, line_number_, problem, excerpt(line));
  }

  const std::unique_ptr<std::istream> in_;
  const std::string label_;
  uint64_t page_bytes_ = 0;
  uint64_t line_number_ = 1;
};

class BinaryReader final : public TraceReader {
 public:
  BinaryReader(std::unique_ptr<std::istream> in, std::string label)
      : in_(std::move(in)), label_(std::move(label)) {
    std::array<char, kBinaryMagic.size()> magic{};
    in_->read(magic.data(), magic.size());
    if (static_cast<size_t>(in_->gcount()) != magic.size() ||
        std::string_view(magic.data(), magic.size()) != kBinaryMagic)
      fail("{}: expected a binary trace of version 1, found other first bytes", label_);
    page_bytes_ = varint();
    if (page_bytes_ < 1 || page_bytes_ > kMaxBytes)
      fail("{}: expected 1 to 2^40 bytes a page, found {}", label_, page_bytes_);
  }

  bool next(TraceRecord& record) override {
    if (ended_) return false;
    const uint8_t tag = byte();
    if (tag == kEnd) {
      readEnd();
      return false;
    }
    if ((tag & kRecord) == 0 || tag > (kRecord | kSameVisit | kSameShape))
      fail("{}: record {}: expected a record or the end, found tag {}", label_, records_ + 1, tag);
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
      if (const char* problem = problemOf(last_))
        fail("{}: record {}: expected {}, found pages {} moved {} needed {} extended {} empty {}",
             label_, records_ + 1, problem, pages, last_.bytes.moved, last_.bytes.needed,
             last_.bytes.extended, last_.bytes.empty);
    }
    ++records_;
    record = last_;
    return true;
  }
  uint64_t pageBytes() const override { return page_bytes_; }

 private:
  uint8_t byte() {
    const int c = in_->rdbuf()->sbumpc();
    if (c == std::char_traits<char>::eof())
      fail("{}: record {}: the file ends in the middle; record the trace again", label_,
           records_ + 1);
    return static_cast<uint8_t>(c);
  }
  uint64_t varint() {
    uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const uint8_t b = byte();
      if (shift == 63 && b > 1) break;
      value |= static_cast<uint64_t>(b & 127u) << shift;
      if (b < 128) return value;
    }
    fail("{}: record {}: expected a number below 2^64, found a longer one", label_, records_ + 1);
  }
  static uint64_t unzigzag(uint64_t v) { return (v >> 1) ^ (~(v & 1) + 1); }
  void readEnd() {
    const uint64_t promised = varint();
    if (promised != records_)
      fail("{}: expected {} records, found {}; record the trace again", label_, promised, records_);
    ended_ = true;
  }

  const std::unique_ptr<std::istream> in_;
  const std::string label_;
  uint64_t page_bytes_ = 0;
  uint64_t records_ = 0;
  bool ended_ = false;
  TraceRecord last_;
};

}  // namespace

std::unique_ptr<TraceReader> makeTextReader(std::unique_ptr<std::istream> in, std::string label) {
  return std::make_unique<TextReader>(std::move(in), std::move(label));
}

std::unique_ptr<TraceReader> makeBinaryReader(std::unique_ptr<std::istream> in, std::string label) {
  return std::make_unique<BinaryReader>(std::move(in), std::move(label));
}

}  // namespace sluice::trace_internal

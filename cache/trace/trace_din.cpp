// dinero's din, and ours, which writes more where dinero ignores the rest of a line. After the
// address of a request's first page comes its record in text format, in the first line with the
// text format's first line before it, and at the end of the last line "records N".
#include <charconv>

#include "cache/policies/key_table.h"
#include "cache/trace/trace_formats.h"

namespace sluice::trace_internal {
namespace {

// A line a page: beyond this a file is of no use to anyone.
constexpr uint64_t kMostPages = uint64_t{1} << 30;

class DinReader final : public Reader {
 public:
  DinReader(Stream in, std::string label, uint64_t page_bytes)
      : Reader(std::move(in), std::move(label), page_bytes) {
    carries_clusters_ = false;
    Line line;
    // An empty file is a trace without requests.
    if (!nextLine(line)) return;
    std::string_view rest = line.rest;
    if (rest.starts_with(kTextMagic)) {
      rest.remove_prefix(kTextMagic.size());
      if (!takeNumber(rest, page_bytes_) || page_bytes_ < 1 || page_bytes_ > kMaxBytes ||
          !takeCharacter(rest, ' '))
        failRecord(line);
      carries_clusters_ = true;
    }
    first_ = {line.address, line.text, rest};
    is_first_ = true;
  }

  bool next(TraceRecord& record) override {
    Line line;
    if (std::exchange(is_first_, false)) {
      line = first_;
    } else if (!nextLine(line)) {
      // Our traces end with their number of records, so that a cut is seen.
      if (carries_clusters_ && !is_complete_) failCut();
      if (!carries_clusters_) warnIfCut();
      return false;
    }
    record = carries_clusters_ ? ours(line) : foreign(line);
    ++records_;
    if (is_complete_) checkPromised(promised_);
    return true;
  }

 private:
  struct Line {
    uint64_t address = 0;
    std::string_view text, rest;  // the whole line, and the part after the address
  };

  bool nextLine(Line& line) {
    std::string_view rest;
    do {
      if (!in_.line(line.text)) return false;
      rest = line.text;
      skipSpaces(rest);
    } while (rest.empty());
    const bool is_label = rest.front() >= '0' && rest.front() <= '2';
    rest.remove_prefix(1);
    const bool is_apart = !rest.empty() && (rest.front() == ' ' || rest.front() == '\t');
    skipSpaces(rest);
    if (rest.starts_with("0x")) rest.remove_prefix(2);
    const auto [end, error] =
        std::from_chars(rest.data(), rest.data() + rest.size(), line.address, 16);
    rest.remove_prefix(static_cast<size_t>(end - rest.data()));
    const bool has_end = rest.empty() || rest.front() == ' ' || rest.front() == '\t';
    if (!is_label || !is_apart || error != std::errc() || !has_end)
      fail("{}:{}: expected a label 0 to 2 and a hexadecimal address, found {}", in_.label(),
           in_.lineNumber(), excerpt(line.text));
    skipSpaces(rest);
    line.rest = rest;
    return true;
  }

  TraceRecord foreign(const Line& line) const {
    return recordOfSize(line.address / page_bytes_, page_bytes_, 0, page_bytes_);
  }

  // A request's first line and its other pages' lines.
  TraceRecord ours(Line line) {
    RecordFields fields;
    if (is_complete_ || !takeRecord(line.rest, fields)) failRecord(line);
    const TraceRecord record = recordOf(fields, in_, line.text);
    const uint64_t first = line.address;
    for (uint64_t page = 1; page < record.pages; ++page) {
      readEnd(line);
      if (is_complete_) failRecord(line);
      if (!nextLine(line)) failCut();
      if (line.address != first + page * page_bytes_) failRecord(line);
    }
    if (record.pages == 1) takeCharacter(line.rest, ' ');
    readEnd(line);
    return record;
  }
  void readEnd(Line& line) {
    if (line.rest.empty()) return;
    if (!line.rest.starts_with(kRecordsWord)) failRecord(line);
    line.rest.remove_prefix(kRecordsWord.size());
    is_complete_ = takeNumber(line.rest, promised_) && line.rest.empty();
    if (!is_complete_) failRecord(line);
  }
  [[noreturn]] void failRecord(const Line& line) const {
    fail(
        "{}:{}: expected a request of 8 or {} whole numbers or its next page, found {}; record the "
        "trace again",
        in_.label(), in_.lineNumber(), RecordFields{}.size(), excerpt(line.text));
  }

  Line first_;  // the first line, which tells whose file it is
  bool is_first_ = false;
  bool is_complete_ = false;  // the line with their number has come
  uint64_t promised_ = 0;
};

class DinWriter final : public Writer {
 public:
  using Writer::Writer;
  void write(const TraceRecord& r) override {
    const uint32_t key = keys_.insert(r.chunk);
    if (key == first_page_.size()) {
      first_page_.push_back(next_page_);
      pages_.push_back(r.pages);
      next_page_ += r.pages;
    }
    // An address stands for a chunk's first page, so that chunks may not overlap.
    if (r.pages != pages_[key])
      fail("{}: chunk {} was requested with {} pages and then with {}; din cannot tell them apart",
           path_, r.chunk, pages_[key], r.pages);
    lines_ += r.pages;
    if (lines_ > kMostPages || next_page_ > UINT64_MAX / page_bytes_)
      fail(
          "{}: din has a line a page, and the trace requests more than {} of them; write text or "
          "binary",
          path_, kMostPages);
    const uint64_t address = first_page_[key] * page_bytes_;
    if (records_++ == 0) {
      out_.append(fmt::format("0 {:x} {}{} {}", address, kTextMagic, page_bytes_, textOf(r)));
    } else {
      out_.append(fmt::format("\n0 {:x} {}", address, textOf(r)));
    }
    for (uint64_t page = 1; page < r.pages; ++page)
      out_.append(fmt::format("\n0 {:x}", address + page * page_bytes_));
  }
  void finish() override {
    if (records_ > 0) out_.append(fmt::format(" {}{}\n", kRecordsWord, records_));
    Writer::finish();
  }

 private:
  KeyTable keys_;
  std::vector<uint64_t> first_page_;  // by key
  std::vector<uint32_t> pages_;       // by key
  uint64_t next_page_ = 0;
  uint64_t lines_ = 0;
};

}  // namespace

std::unique_ptr<TraceReader> makeDinReader(Stream in, std::string label, uint64_t page_bytes) {
  return std::make_unique<DinReader>(std::move(in), std::move(label), page_bytes);
}
std::unique_ptr<TraceWriter> makeDinWriter(const std::filesystem::path& path, uint64_t page_bytes) {
  return std::make_unique<DinWriter>(path, page_bytes);
}

}  // namespace sluice::trace_internal

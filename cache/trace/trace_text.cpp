// The text format.
#include "cache/trace/trace_formats.h"

namespace sluice::trace_internal {
namespace {

// Ends the first comment of the files that we write: the number of their records stands at their
// end. Files that others write need not.
constexpr std::string_view kPromise = "; the last line is '# records N'";

class TextReader final : public Reader {
 public:
  TextReader(Stream in, std::string label) : Reader(std::move(in), std::move(label), 0) {
    std::string_view line;
    in_.line(line);
    std::string_view rest = line.substr(std::min(line.size(), kTextMagic.size()));
    if (!line.starts_with(kTextMagic) || !takeNumber(rest, page_bytes_) || !rest.empty() ||
        page_bytes_ < 1 || page_bytes_ > kMaxBytes)
      fail("{}:1: expected '{}N', found {}; is it a trace?", in_.label(), kTextMagic,
           excerpt(line));
  }

  bool next(TraceRecord& record) override {
    std::string_view line;
    while (in_.line(line)) {
      if (line.empty()) continue;
      if (line.front() == '#') {
        readComment(line);
        continue;
      }
      RecordFields fields;
      std::string_view rest = line;
      if (!takeRecord(rest, fields) || !rest.empty())
        fail("{}:{}: expected 8 or 9 whole numbers with single spaces, found {}", in_.label(),
             in_.lineNumber(), excerpt(line));
      record = recordOf(fields, in_, line);
      ++records_;
      return true;
    }
    if (is_promised_) failCut();
    if (promised_) checkPromised(*promised_);
    warnIfCut();
    return false;
  }

 private:
  void readComment(std::string_view line) {
    if (line.ends_with(kPromise)) is_promised_ = true;
    if (!line.substr(1).starts_with(" ") || !line.substr(2).starts_with(kRecordsWord)) return;
    uint64_t promised = 0;
    line.remove_prefix(2 + kRecordsWord.size());
    if (takeNumber(line, promised) && line.empty())
      promised_ = promised;
    else if (is_promised_)
      failCut();
    else
      return;  // a sentence of somebody's
    is_promised_ = false;
  }

  bool is_promised_ = false;          // the number of records is still to come
  std::optional<uint64_t> promised_;  // compared at the end, wherever it stands
};

class TextWriter final : public Writer {
 public:
  TextWriter(const std::filesystem::path& path, uint64_t page_bytes) : Writer(path, page_bytes) {
    out_.append(
        fmt::format("{}{}\n# chunk pages cluster frame moved needed extended empty (bytes of a "
                    "load) [level]{}\n",
                    kTextMagic, page_bytes, kPromise));
  }
  void write(const TraceRecord& r) override {
    out_.append(textOf(r));
    out_.append("\n");
    ++records_;
  }
  void finish() override {
    out_.append(fmt::format("# {}{}\n", kRecordsWord, records_));
    Writer::finish();
  }
};

}  // namespace

std::unique_ptr<TraceReader> makeTextReader(Stream in, std::string label) {
  return std::make_unique<TextReader>(std::move(in), std::move(label));
}
std::unique_ptr<TraceWriter> makeTextWriter(const std::filesystem::path& path,
                                            uint64_t page_bytes) {
  return std::make_unique<TextWriter>(path, page_bytes);
}

}  // namespace sluice::trace_internal

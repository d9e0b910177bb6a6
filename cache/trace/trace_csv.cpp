// libCacheSim's csv, and ours, which has more columns than libCacheSim looks at:
//   time,obj_id,obj_size,cluster,pages_of_N_bytes,needed,extended,empty,level,records
// time is the frame, obj_size the bytes moved; records is empty except in the last line, which has
// the number of lines there, so that a cut file is noticed. Older files have no level.
#include <algorithm>
#include <array>
#include <cctype>
#include <span>

#include "cache/trace/trace_formats.h"

namespace sluice::trace_internal {
namespace {

constexpr std::string_view kOurStart = "time,obj_id,obj_size,cluster,pages_of_";
constexpr std::string_view kOurEnd = "_bytes,needed,extended,empty,level,records";
constexpr std::string_view kOlderEnd = "_bytes,needed,extended,empty,records";

// A name: letters first, maybe quoted or commented out.
bool isColumnName(std::string_view field) {
  while (!field.empty() && (field.front() == ' ' || field.front() == '"' || field.front() == '#'))
    field.remove_prefix(1);
  if (field.empty()) return false;
  const auto first = static_cast<unsigned char>(field.front());
  return (std::isalpha(first) != 0 || first == '_') &&
         std::all_of(field.begin(), field.end(),
                     [](char c) { return std::isprint(static_cast<unsigned char>(c)) != 0; });
}

// Three names at least.
bool isHeader(std::string_view line) {
  if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // a byte order mark
  for (int field = 0; field < 3; ++field) {
    const size_t end = std::min(line.find(','), line.size());
    if (!isColumnName(line.substr(0, end)) || (field < 2 && end == line.size())) return false;
    line.remove_prefix(std::min(line.size(), end + 1));
  }
  return true;
}

class CsvReader final : public Reader {
 public:
  CsvReader(Stream in, std::string label, uint64_t page_bytes)
      : Reader(std::move(in), std::move(label), page_bytes) {
    carries_clusters_ = false;
    std::string_view line;
    if (!in_.line(line)) return;
    if (line.starts_with(kOurStart)) {
      readOurHeader(line);
    } else if (!isHeader(line)) {
      first_ = line;
      is_first_ = true;
    }
  }

  bool next(TraceRecord& record) override {
    std::string_view line;
    if (std::exchange(is_first_, false)) {
      line = first_;
    } else {
      do {
        if (!in_.line(line)) {
          // Ours end with the number of records; those of others cannot tell.
          if (carries_clusters_ && !is_complete_) failCut();
          if (!carries_clusters_) warnIfCut();
          return false;
        }
      } while (line.find_first_not_of(" \t") == std::string_view::npos);
    }
    record = carries_clusters_ ? ours(line) : foreign(line);
    ++records_;
    if (is_complete_) checkPromised(promised_);
    return true;
  }

 private:
  void readOurHeader(std::string_view line) {
    std::string_view rest = line.substr(kOurStart.size());
    const bool has_number = takeNumber(rest, page_bytes_);
    has_levels_ = rest == kOurEnd;
    if (!has_number || !(has_levels_ || rest == kOlderEnd) || page_bytes_ < 1 ||
        page_bytes_ > kMaxBytes)
      fail("{}:1: expected '{}N{}', found {}; record the trace again", in_.label(), kOurStart,
           kOurEnd, excerpt(line.substr(kOurStart.size())));
    carries_clusters_ = true;
  }

  TraceRecord foreign(std::string_view line) {
    std::string_view rest = line;
    std::array<uint64_t, 3> fields;  // time, id, size
    bool parsed = true;
    for (size_t i = 0; i < fields.size() && parsed; ++i) {
      skipSpaces(rest);
      parsed = takeNumber(rest, fields[i]);
      // Fractions of a second are dropped.
      if (i == 0 && takeCharacter(rest, '.')) {
        uint64_t ignored = 0;
        parsed = parsed && (takeNumber(rest, ignored) || rest.starts_with(','));
      }
      skipSpaces(rest);
      const bool ended = i + 1 == fields.size() && rest.empty();
      parsed = parsed && (ended || takeCharacter(rest, ','));
    }
    if (!parsed || fields[2] > kMaxBytes)
      fail("{}:{}: expected time,obj_id,obj_size as whole numbers{}, found {}", in_.label(),
           in_.lineNumber(), in_.lineNumber() == 1 ? " or as the columns' names" : "",
           excerpt(line));
    return sized(fields[1], fields[2], fields[0],
                 [&] { return fmt::format("{}:{}", in_.label(), in_.lineNumber()); });
  }

  TraceRecord ours(std::string_view line) {
    std::string_view rest = line;
    // Frame, chunk, moved, cluster, pages, needed, extended, empty, level.
    std::array<uint64_t, 9> v{};
    const std::span<uint64_t> fields(v.data(), v.size() - (has_levels_ ? 0 : 1));
    bool parsed = !is_complete_;
    for (uint64_t& field : fields)
      parsed = parsed && takeNumber(rest, field) && takeCharacter(rest, ',');
    if (parsed && !rest.empty()) {
      parsed = takeNumber(rest, promised_) && rest.empty();
      is_complete_ = true;
    }
    if (!parsed)
      fail(
          "{}:{}: expected {} whole numbers with commas and nothing after the last record, found "
          "{}; record the trace again",
          in_.label(), in_.lineNumber(), fields.size(), excerpt(line));
    return recordOf({v[1], v[4], v[3], v[0], v[2], v[5], v[6], v[7], v[8]}, in_, line);
  }

  std::string_view first_;  // the first line, when it is a record
  bool is_first_ = false;
  bool has_levels_ = false;   // ours, with a level in each line
  bool is_complete_ = false;  // the line with their number has come
  uint64_t promised_ = 0;
};

class CsvWriter final : public Writer {
 public:
  CsvWriter(const std::filesystem::path& path, uint64_t page_bytes) : Writer(path, page_bytes) {
    out_.append(fmt::format("{}{}{}\n", kOurStart, page_bytes, kOurEnd));
  }
  void write(const TraceRecord& r) override {
    if (records_ > 0) out_.append("\n");
    out_.append(fmt::format("{},{},{},{},{},{},{},{},{},", r.frame, r.chunk, r.bytes.moved,
                            r.cluster, r.pages, r.bytes.needed, r.bytes.extended, r.bytes.empty,
                            r.level));
    ++records_;
  }
  void finish() override {
    if (records_ > 0) out_.append(fmt::format("{}\n", records_));
    Writer::finish();
  }
};

}  // namespace

std::unique_ptr<TraceReader> makeCsvReader(Stream in, std::string label, uint64_t page_bytes) {
  return std::make_unique<CsvReader>(std::move(in), std::move(label), page_bytes);
}
std::unique_ptr<TraceWriter> makeCsvWriter(const std::filesystem::path& path, uint64_t page_bytes) {
  return std::make_unique<CsvWriter>(path, page_bytes);
}

}  // namespace sluice::trace_internal

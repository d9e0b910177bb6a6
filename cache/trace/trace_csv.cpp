// libCacheSim's csv, whose line of names, if there is one, tells which columns are read; and ours,
// which has more columns than libCacheSim looks at:
//   time,obj_id,obj_size,cluster,pages_of_N_bytes,needed,extended,empty,level,records
// time is the frame, obj_size the bytes moved; records is empty except in the last line, which has
// the number of lines there, so that a cut file is noticed. Older files have no level.
#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cache/trace/trace_formats.h"

namespace sluice::trace_internal {
namespace {

constexpr std::string_view kOurStart = "time,obj_id,obj_size,cluster,pages_of_";
constexpr std::string_view kOurEnd = "_bytes,needed,extended,empty,level,records";
constexpr std::string_view kOlderEnd = "_bytes,needed,extended,empty,records";

enum class Column { kTime, kId, kSize, kOther };

constexpr std::array<std::string_view, 3> kColumns{"time", "obj_id", "obj_size"};

// The column of a name, as libCacheSim and those who write for it call it.
Column columnOf(std::string_view name) {
  constexpr std::pair<std::string_view, Column> kNames[] = {
      {"time", Column::kTime},        {"timestamp", Column::kTime},
      {"ts", Column::kTime},          {"clock_time", Column::kTime},
      {"real_time", Column::kTime},   {"obj_id", Column::kId},
      {"object_id", Column::kId},     {"object", Column::kId},
      {"obj", Column::kId},           {"id", Column::kId},
      {"key", Column::kId},           {"obj_size", Column::kSize},
      {"object_size", Column::kSize}, {"size", Column::kSize}};
  for (const auto& [known, column] : kNames)
    if (name == known) return column;
  return Column::kOther;
}

// A column's name, maybe quoted or commented out, in small letters and with one kind of hyphen.
// Empty if it is none: letters come first.
std::string nameOf(std::string_view field) {
  constexpr std::string_view kAround = " \t\"#";
  const size_t first = field.find_first_not_of(kAround);
  if (first == std::string_view::npos) return "";
  std::string name(field.substr(first, field.find_last_not_of(kAround) + 1 - first));
  const auto begin = static_cast<unsigned char>(name.front());
  if (std::isalpha(begin) == 0 && begin != '_') return "";
  for (char& c : name) {
    if (std::isprint(static_cast<unsigned char>(c)) == 0) return "";
    c = c == '-' || c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return name;
}

// Skips a field up to its comma or the end. A quoted one may have commas inside.
void skipField(std::string_view& text) {
  const size_t quoted = text.starts_with('"') ? text.find('"', 1) : 0;
  const size_t from = quoted == std::string_view::npos ? 0 : quoted;
  text.remove_prefix(std::min(text.find(',', from), text.size()));
}

// The names of a line that has three at least, and nothing else in front of the third; else none.
std::vector<std::string> namesIn(std::string_view line) {
  constexpr size_t kLeast = 3;
  if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);  // a byte order mark
  std::vector<std::string> names;
  for (bool is_more = true; is_more; is_more = takeCharacter(line, ',')) {
    std::string_view rest = line;
    skipField(rest);
    names.push_back(nameOf(line.substr(0, line.size() - rest.size())));
    if (names.back().empty() && names.size() <= kLeast) return {};
    line = rest;
  }
  return names.size() < kLeast ? std::vector<std::string>() : names;
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
    } else if (const std::vector<std::string> names = namesIn(line); !names.empty()) {
      readNames(names, line);
    } else {
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

  // The columns up to the last one that is read.
  void readNames(const std::vector<std::string>& names, std::string_view line) {
    columns_.clear();
    std::array<int, 3> counts{};
    size_t last = 0;
    for (const std::string& name : names) {
      columns_.push_back(columnOf(name));
      if (columns_.back() == Column::kOther) continue;
      ++counts[static_cast<size_t>(columns_.back())];
      last = columns_.size();
    }
    columns_.resize(last);
    if (counts != std::array{1, 1, 1})
      fail(
          "{}:1: expected the columns' names time, obj_id and obj_size once each, in any order, "
          "found {}; rename the columns",
          in_.label(), excerpt(line));
  }

  // The columns that a line must have, for messages.
  std::string columnNames() const {
    std::vector<std::string_view> names;
    for (const Column column : columns_)
      names.push_back(column == Column::kOther ? "..." : kColumns[static_cast<size_t>(column)]);
    return fmt::format("{}", fmt::join(names, ","));
  }

  TraceRecord foreign(std::string_view line) {
    std::string_view rest = line;
    std::array<uint64_t, 3> fields{};  // time, id, size
    bool parsed = true;
    for (size_t i = 0; i < columns_.size() && parsed; ++i) {
      skipSpaces(rest);
      const Column column = columns_[i];
      if (column == Column::kOther)
        skipField(rest);
      else
        parsed = takeNumber(rest, fields[static_cast<size_t>(column)]);
      // Fractions of a second are dropped.
      if (column == Column::kTime && takeCharacter(rest, '.')) {
        uint64_t ignored = 0;
        parsed = parsed && (takeNumber(rest, ignored) || rest.empty() || rest.starts_with(','));
      }
      skipSpaces(rest);
      const bool ended = i + 1 == columns_.size() && rest.empty();
      parsed = parsed && (ended || takeCharacter(rest, ','));
    }
    const auto [time, id, size] = fields;
    if (!parsed || size > kMaxBytes)
      fail("{}:{}: expected {} as whole numbers{}, found {}", in_.label(), in_.lineNumber(),
           columnNames(), in_.lineNumber() == 1 ? " or as the columns' names" : "", excerpt(line));
    return sized(id, size, time,
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

  // Foreign files have these columns, up to the last one that is read.
  std::vector<Column> columns_{Column::kTime, Column::kId, Column::kSize};
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

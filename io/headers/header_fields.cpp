#include "io/headers/header_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "src/base/files/number_text.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

constexpr std::string_view kWhite = " \t\r\n\v\f";
constexpr size_t kQuotedCharacters = 60;

template <class T>
std::optional<T> parseAll(std::string_view text) {
  // std::from_chars() takes no plus sign.
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return numberIn<T>(text);
}

}  // namespace

std::vector<std::string_view> splitWords(std::string_view text) {
  std::vector<std::string_view> words;
  size_t begin = text.find_first_not_of(kWhite);
  while (begin != std::string_view::npos) {
    const size_t end = std::min(text.find_first_of(kWhite, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(kWhite, end);
  }
  return words;
}

std::optional<int64_t> parseInteger(std::string_view text) {
  return parseAll<int64_t>(text);
}

std::optional<double> parseReal(std::string_view text) {
  return parseAll<double>(text);
}

std::string inQuotes(std::string_view text) {
  std::string line = "'";
  for (const char c : text.substr(0, kQuotedCharacters)) line += c >= ' ' && c <= '~' ? c : '?';
  return line + (text.size() > kQuotedCharacters ? "...'" : "'");
}

bool isNearMiss(std::string_view text, std::string_view known) {
  constexpr size_t kMostSlips = 2;
  const std::string a = lowercase(text), b = lowercase(known);
  if (a.size() > b.size() + kMostSlips || b.size() > a.size() + kMostSlips) return false;
  // Levenshtein's distance, row by row.
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({changed, row[j] + 1, row[j - 1] + 1}));
    }
  }
  return text != known && row[b.size()] <= kMostSlips;
}

std::string unknownFieldsNote(const std::string& path, const std::vector<std::string>& names) {
  constexpr size_t kMostShown = 4;
  std::string list;
  for (size_t i = 0; i < std::min(names.size(), kMostShown); ++i)
    list += (list.empty() ? "" : ", ") + inQuotes(names[i]);
  if (names.size() > kMostShown) list += fmt::format(" and {} more", names.size() - kMostShown);
  return fmt::format("{}: its header has {} without a meaning, which {} passed over: {}", path,
                     names.size() == 1 ? "a field" : "fields", names.size() == 1 ? "is" : "are",
                     list);
}

std::optional<std::string_view> LineReader::next() {
  if (position_ >= text_.size()) return std::nullopt;
  const size_t end = std::min(text_.find('\n', position_), text_.size());
  std::string_view line = text_.substr(position_, end - position_);
  position_ = std::min(end + 1, text_.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

}  // namespace sluice

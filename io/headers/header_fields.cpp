#include "io/headers/header_fields.h"

#include <charconv>

namespace sluice {
namespace {

constexpr std::string_view kWhite = " \t\r\n\v\f";
constexpr size_t kQuotedCharacters = 60;

template <class T>
std::optional<T> parseAll(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(kWhite);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kWhite) - begin + 1);
}

std::string lowercase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

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

std::string quoted(std::string_view text) {
  std::string line = "'";
  for (const char c : text.substr(0, kQuotedCharacters)) line += c >= ' ' && c <= '~' ? c : '?';
  return line + (text.size() > kQuotedCharacters ? "...'" : "'");
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

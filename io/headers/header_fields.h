// The small change of text headers: lines, words, numbers, and how they are quoted in messages.
//
// Pure functions on views into the caller's text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/values/text_parts.h"  // IWYU pragma: export

namespace sluice {

// The words between runs of spaces and tabs.
std::vector<std::string_view> splitWords(std::string_view text);

// All of `text` (a sign allowed); nullopt when it is something else or out of range.
std::optional<int64_t> parseInteger(std::string_view text);
// The same; "nan" and "inf" are numbers.
std::optional<double> parseReal(std::string_view text);

// The text for a message: in quotation marks, on one line, printable, cut after 60 characters.
std::string inQuotes(std::string_view text);

// Whether `text` is not `known` but becomes it by at most two letters that are changed, put in or
// taken out, upper and lower case being the same: a slip of the hand or a flipped bit.
bool isNearMiss(std::string_view text, std::string_view known);
// A note for people, which starts with `path`: names in a header that mean nothing and are passed
// over; `names` not empty.
std::string unknownFieldsNote(const std::string& path, const std::vector<std::string>& names);

// Takes lines off the front of a text; "\n" and "\r\n" end one, the end of the text too.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : text_(text) {}
  // nullopt at the end of the text.
  std::optional<std::string_view> next();
  // The position at which the next line starts.
  size_t position() const { return position_; }

 private:
  const std::string_view text_;
  size_t position_ = 0;
};

}  // namespace sluice

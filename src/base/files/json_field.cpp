#include "src/base/files/json_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr int kDeepest = 32;

std::string describe(const nlohmann::json& value) {
  if (value.is_array()) return fmt::format("an array of {}", value.size());
  if (value.is_object()) return fmt::format("an object of {}", value.size());
  if (value.is_string()) return fmt::format("'{}'", printable(value.get_ref<const std::string&>()));
  return value.dump();
}

// A character of UTF-8.
struct Character {
  uint32_t code = 0;
  size_t bytes = 0;  // 0: the text does not begin with one
};

Character firstCharacter(std::string_view text) {
  const auto byteAt = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byteAt(0);
  if (first < 0x80) return {first, 1};
  // Lead bytes of UTF-8 (RFC 3629): 0xc0 and 0xc1 would only begin overlong forms, and 0xf5 on lies
  // beyond U+10FFFF.
  const size_t bytes = first < 0xc2   ? 0
                       : first < 0xe0 ? 2
                       : first < 0xf0 ? 3
                       : first < 0xf5 ? 4
                                      : 0;
  if (bytes == 0 || text.size() < bytes) return {};
  uint32_t code = first & (0xffU >> (bytes + 1));
  for (size_t i = 1; i < bytes; ++i) {
    if ((byteAt(i) & 0xc0U) != 0x80) return {};
    code = code << 6 | (byteAt(i) & 0x3fU);
  }
  const bool is_too_long = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
  const bool is_surrogate = code >= 0xd800 && code < 0xe000;
  if (is_too_long || is_surrogate || code > 0x10ffff) return {};
  return {code, bytes};
}

// Characters that control a terminal, break the line or change the direction of writing, or that
// nobody sees.
bool isPrintable(uint32_t code) {
  constexpr std::pair<uint32_t, uint32_t> kHidden[] = {
      {0, 0x1f},        {0x7f, 0x9f},     {0xad, 0xad},     {0x61c, 0x61c},   {0x200b, 0x200f},
      {0x2028, 0x202e}, {0x2060, 0x206f}, {0xfeff, 0xfeff}, {0xfff9, 0xfffb}, {0xe0000, 0xe0fff}};
  return std::ranges::none_of(
      kHidden, [&](const auto& range) { return code >= range.first && code <= range.second; });
}

// Text of 16 or 32 bits a character begins with a mark of its byte order, or has a zero byte in its
// first two characters, which in JSON are ASCII.
bool isWideText(std::string_view text) {
  return text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") ||
         (text.size() > 1 && text.substr(0, 4).find('\0') != std::string_view::npos);
}

bool isBlank(std::string_view text) {
  return text.find_first_not_of(" \t\r\n") == std::string_view::npos;
}

}  // namespace

std::string printable(std::string_view text, size_t longest) {
  std::string line;
  while (!text.empty()) {
    const Character character = firstCharacter(text);
    const size_t bytes = std::max<size_t>(character.bytes, 1);
    if (line.size() + bytes > longest) return line + "...";
    const bool is_shown = character.bytes > 0 && isPrintable(character.code);
    line += is_shown ? text.substr(0, bytes) : "?";
    text.remove_prefix(bytes);
  }
  return line;
}

nlohmann::json parseJson(std::string_view text, const std::string& where) {
  if (isBlank(text)) fail("{}: expected JSON, found an empty file", where);
  if (isWideText(text))
    fail(
        "{}: expected JSON in UTF-8, found zero bytes or a mark of UTF-16 at its beginning; save "
        "it as UTF-8",
        where);
  using Event = nlohmann::json::parse_event_t;
  std::vector<std::set<std::string>> keys;  // one set for each open object
  const auto check = [&](int depth, Event event, nlohmann::json& value) {
    // The library's parser and destructor recurse, so that a file of brackets would overflow the
    // stack.
    if (depth > kDeepest)
      fail("{}: expected at most {} levels of nesting, found more", where, kDeepest);
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    // The library would take the last one in silence.
    if (event == Event::key && !keys.back().insert(value.get<std::string>()).second)
      fail("{}: expected each key of an object once, found '{}' twice", where,
           printable(value.get<std::string>()));
    return true;
  };
  try {
    return nlohmann::json::parse(text.begin(), text.end(), check);
  } catch (const nlohmann::json::exception& error) {
    // The library's own "[json.exception.parse_error.101] " means nothing to a person.
    std::string_view reason = error.what();
    if (const size_t end = reason.find("] "); end != reason.npos) reason.remove_prefix(end + 2);
    fail("{}: expected JSON, found {}", where, printable(reason, 200));
  }
}

size_t JsonField::size() const {
  if (!value_->is_array()) failExpected("an array");
  return value_->size();
}

JsonField JsonField::operator[](size_t index) const {
  SLUICE_CHECK_LT(index, size());
  return {(*value_)[index], where_, fmt::format("{}/{}", place_, index)};
}

std::optional<JsonField> JsonField::find(const char* key) const {
  if (!value_->is_object()) failExpected("an object");
  const auto found = value_->find(key);
  if (found == value_->end()) return std::nullopt;
  return JsonField(*found, where_, fmt::format("{}/{}", place_, key));
}

JsonField JsonField::require(const char* key) const {
  auto field = find(key);
  if (!field) fail("{}: expected the field {}/{}, found none", where_, place_, key);
  return *std::move(field);
}

void JsonField::allowOnly(const std::vector<std::string_view>& keys) const {
  if (!value_->is_object()) failExpected("an object");
  for (const auto& [key, value] : value_->items()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    fail("{}: expected one of the fields {}, found '{}'", where_, fmt::join(keys, ", "),
         printable(key));
  }
}

double JsonField::number() const {
  if (!value_->is_number()) failExpected("a number");
  const auto number = value_->get<double>();
  if (!std::isfinite(number)) failExpected("a finite number");
  return number;
}

int64_t JsonField::whole() const {
  // The library returns unsigned numbers above 2^63 - 1 as negative ones.
  const bool fits = value_->is_number_unsigned()
                        ? value_->get<uint64_t>() <= uint64_t{std::numeric_limits<int64_t>::max()}
                        : value_->is_number_integer();
  if (!fits) failExpected("a whole number");
  return value_->get<int64_t>();
}

double JsonField::share() const {
  const double value = number();
  if (value < 0 || value > 1) failExpected("a number in 0..1");
  return value;
}

const std::string& JsonField::text() const {
  if (!value_->is_string()) failExpected("a text");
  return value_->get_ref<const std::string&>();
}

bool JsonField::flag() const {
  if (value_->is_boolean()) return value_->get<bool>();
  if (value_->is_number()) return number() != 0;
  failExpected("true or false");
}

void JsonField::failExpected(std::string_view expected) const {
  fail("{}: expected {} at {}, found {}", where_, expected, place_.empty() ? "the top" : place_,
       describe(*value_));
}

}  // namespace sluice

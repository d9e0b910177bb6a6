// JsonField: a value of a JSON document that knows its file and its place in it. A reader gets the
// expected value, or an Error that names file, place, the expected and the found value.
//
// Refers to a document, which must outlive it. One thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sluice {

// Parses `text`. Throws Error, starting with `where`, when it is not JSON, nests deeper than any
// file of ours does, or has a key twice in one object.
nlohmann::json parseJson(std::string_view text, const std::string& where);

// `text` as one line of printable characters, in UTF-8, of at most `longest` bytes and "...",
// whatever a file holds; for messages and for names that messages show. Other bytes become "?".
std::string printable(std::string_view text, size_t longest = 60);
// Bytes of a name that a file gives to a channel or an array: enough for every name that a person
// wrote.
inline constexpr size_t kLongestName = 200;

class JsonField {
 public:
  // The document itself.
  JsonField(const nlohmann::json& value, std::string where)
      : value_(&value), where_(std::move(where)) {}

  bool isObject() const { return value_->is_object(); }
  bool isArray() const { return value_->is_array(); }
  bool isText() const { return value_->is_string(); }
  bool isNumber() const { return value_->is_number(); }
  bool isFlag() const { return value_->is_boolean(); }
  bool isNull() const { return value_->is_null(); }
  // Elements of an array. Throws Error when it is none.
  size_t size() const;
  JsonField operator[](size_t index) const;
  // The member of an object; nullopt when it has none of that name. Throws Error when not an
  // object.
  std::optional<JsonField> find(const char* key) const;
  // The same; throws Error when it has none.
  JsonField require(const char* key) const;
  // Throws Error, listing the names, when the object has a member of another one: a misspelt field
  // would be ignored in silence.
  void allowOnly(const std::vector<std::string_view>& keys) const;

  // Finite, as JSON has no other numbers.
  double number() const;
  // A number without a fraction that fits 63 bits and a sign.
  int64_t whole() const;
  // A number in 0..1.
  double share() const;
  const std::string& text() const;
  // true or false, or a number, as some programs write them.
  bool flag() const;

  // Throws Error with the file, the field's place, what was expected, and what stands there.
  [[noreturn]] void failExpected(std::string_view expected) const;

 private:
  JsonField(const nlohmann::json& value, std::string where, std::string place)
      : value_(&value), where_(std::move(where)), place_(std::move(place)) {}

  const nlohmann::json* value_;
  std::string where_;
  std::string place_;  // a JSON pointer; empty for the document
};

}  // namespace sluice

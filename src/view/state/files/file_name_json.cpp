#include "src/view/state/files/file_name_json.h"

#include <nlohmann/json.hpp>

#include "src/base/files/json_field.h"

namespace sluice {
namespace {

bool isUtf8(const std::string& text) {
  try {
    nlohmann::json(text).dump();  // throws for anything else
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

}  // namespace

nlohmann::json fileNameJson(const std::string& name) {
  // File names of POSIX are any bytes, and JSON is UTF-8: other names are written byte by byte as
  // characters up to U+00FF.
  if (isUtf8(name)) return name;
  std::string characters;  // U+0000 to U+00FF, as UTF-8
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      characters += c;
    } else {
      characters += static_cast<char>(0xc0 | byte >> 6);
      characters += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return {{"bytes", characters}};
}

namespace {

// The system would take a name up to its first zero byte.
const std::string& requireNoZero(const std::string& name, const JsonField& field) {
  if (name.find('\0') != std::string::npos) field.failExpected("a name without a zero byte");
  return name;
}

}  // namespace

std::string fileNameOf(const JsonField& field) {
  if (!field.isObject()) return requireNoZero(field.text(), field);
  field.allowOnly({"bytes"});
  const JsonField bytes = field.require("bytes");
  const std::string& characters = bytes.text();
  std::string name;
  for (size_t i = 0; i < characters.size(); ++i) {
    const auto lead = static_cast<unsigned char>(characters[i]);
    if (lead < 0x80) {
      name += characters[i];
    } else if (lead <= 0xc3) {  // two bytes up to U+00FF; the parser took nothing but UTF-8
      const auto next = static_cast<unsigned char>(characters[++i]);
      name += static_cast<char>((lead & 0x03) << 6 | (next & 0x3f));
    } else {
      bytes.failExpected("characters up to U+00FF");
    }
  }
  return requireNoZero(name, bytes);
}

}  // namespace sluice

// Names of files in JSON. A file's name may hold any bytes, JSON only UTF-8: a name that is no
// UTF-8 is written as {"bytes": "..."}, each byte as the character of that number. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sluice {

class JsonField;

// A text, or the object if the name is no UTF-8.
nlohmann::json fileNameJson(const std::string& name);
// The name that fileNameJson() wrote, or the field's text. Throws Error when the field is neither.
std::string fileNameOf(const JsonField& field);

}  // namespace sluice

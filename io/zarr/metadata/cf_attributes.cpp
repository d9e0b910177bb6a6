#include "io/zarr/metadata/cf_attributes.h"

#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace sluice {
namespace {

// The double whose bytes, the lowest first, are this base64; nullopt: it is none.
std::optional<double> doubleOfBase64(std::string_view text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  constexpr size_t kBytes = 8, kDigitsOfBytes = 11;
  if (text.size() != kDigitsOfBytes + 1 || text.back() != '=') return std::nullopt;
  uint64_t bits = 0;
  uint32_t held = 0;
  int held_bits = 0;
  size_t bytes = 0;
  for (const char c : text.substr(0, kDigitsOfBytes)) {
    const size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) return std::nullopt;
    held = held << 6 | static_cast<uint32_t>(digit);
    held_bits += 6;
    if (held_bits < 8) continue;
    held_bits -= 8;
    bits |= uint64_t{held >> held_bits & 0xff} << 8 * bytes++;
  }
  return bytes == kBytes ? std::optional(std::bit_cast<double>(bits)) : std::nullopt;
}

std::vector<double> numbersOf(const JsonField& attributes, const char* key) {
  std::vector<double> found;
  const auto field = attributes.find(key);
  if (!field) return found;
  if (field->isNumber()) found.push_back(field->number());
  if (field->isText())
    if (const auto number = doubleOfBase64(field->text())) found.push_back(*number);
  for (size_t i = 0; field->isArray() && i < field->size(); ++i)
    if ((*field)[i].isNumber()) found.push_back((*field)[i].number());
  return found;
}

}  // namespace

void parseCfAttributes(const JsonField& attributes, ZarrImage& image) {
  if (const auto scale = numbersOf(attributes, "scale_factor"); scale.size() == 1)
    image.value_scale = scale[0];
  if (const auto offset = numbersOf(attributes, "add_offset"); offset.size() == 1)
    image.value_offset = offset[0];
  const auto limit = [&](const char* key, size_t of_range) -> std::optional<double> {
    if (const auto range = numbersOf(attributes, "valid_range"); range.size() == 2)
      return range[of_range];
    const auto numbers = numbersOf(attributes, key);
    return numbers.size() == 1 ? std::optional(numbers[0]) : std::nullopt;
  };
  image.valid_least = limit("valid_min", 0);
  image.valid_greatest = limit("valid_max", 1);
  for (const char* key : {"_FillValue", "missing_value"})
    for (const double number : numbersOf(attributes, key)) image.missing.push_back(number);
}

}  // namespace sluice

#include "src/base/files/numbered_name.h"

#include <fmt/format.h>

#include <algorithm>

#include "src/base/error.h"
#include "src/base/files/number_text.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDigits = "0123456789";

struct NumberPlace {
  size_t length = 0, width = 0;  // characters of the pattern, digits at least
};

// The place that begins with the first character of `text`, '#' or '%'.
std::optional<NumberPlace> placeAtStart(std::string_view text) {
  constexpr size_t kMostWidthDigits = 3;
  if (text[0] == '#') {
    const size_t length = std::min(text.find_first_not_of('#'), text.size());
    return NumberPlace{length, length};
  }
  const size_t end = std::min(text.find_first_not_of(kDigits, 1), text.size());
  const bool is_number =
      end < text.size() && (text[end] == 'd' || text[end] == 'i' || text[end] == 'u');
  if (!is_number || end - 1 > kMostWidthDigits) return std::nullopt;
  return NumberPlace{end + 1, numberIn<size_t>(text.substr(1, end - 1)).value_or(0)};
}

}  // namespace

std::optional<DigitRun> lastDigits(std::string_view name) {
  const size_t last = name.find_last_of(kDigits);
  if (last == std::string_view::npos) return std::nullopt;
  const size_t at = name.find_last_not_of(kDigits, last) + 1;  // npos + 1 is the name's start
  return DigitRun{at, last + 1 - at};
}

std::string NumberedName::with(int64_t number) const {
  return fmt::format("{}{:0{}}{}", before, number, std::max<size_t>(1, width), after);
}

bool NumberedName::matches(std::string_view file) const {
  if (file.size() <= before.size() + after.size() || !file.starts_with(before) ||
      !file.ends_with(after))
    return false;
  const std::string_view digits =
      file.substr(before.size(), file.size() - before.size() - after.size());
  const bool is_padded = digits.size() > 1 && digits[0] == '0';
  return std::ranges::all_of(digits, isDigit) && digits.size() >= width &&
         !(is_padded && digits.size() > width);
}

std::optional<NumberedName> parseNumberedName(std::string_view file) {
  NumberedName name;
  std::string* part = &name.before;
  while (!file.empty()) {
    const bool is_percent_sign = file.starts_with("%%");
    if (is_percent_sign || (file[0] != '#' && file[0] != '%')) {
      *part += file[0];
      file.remove_prefix(is_percent_sign ? 2 : 1);
      continue;
    }
    const auto place = placeAtStart(file);
    if (!place || part == &name.after) return std::nullopt;
    name.width = place->width;
    part = &name.after;
    file.remove_prefix(place->length);
  }
  return part == &name.after ? std::optional(name) : std::nullopt;
}

bool isNumbered(const fs::path& name) {
  return name.filename().string().find_first_of("%#") != std::string::npos;
}

fs::path numberedName(const std::string& name, int64_t number, bool numbered) {
  constexpr size_t kMostWidth = 20;  // beyond the digits of any int64_t
  fs::path path(name);
  if (isNumbered(path)) {
    const auto parsed = parseNumberedName(path.filename().string());
    if (!parsed || parsed->width > kMostWidth)
      failRequest("{}: expected one place for the number, as in turn_####.png or turn_%04d.png",
                  name);
    return path.parent_path() / parsed->with(number);
  }
  if (!numbered) return path;
  const NumberedName after_stem{path.stem().string() + "_", path.extension().string(), 3};
  return path.parent_path() / after_stem.with(number);
}

}  // namespace sluice

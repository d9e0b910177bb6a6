#include "io/headers/file_set.h"

#include <optional>

#include "io/headers/header_fields.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr int kMaxWidth = 20;
constexpr int64_t kMaxNumber = int64_t{1} << 53;  // keeps the count's arithmetic far from overflow

// A printf conversion of an integer inside a name.
struct Conversion {
  size_t begin = 0, end = 0;  // in the pattern
  bool zeros = false;
  int width = 0;
  char kind = 'd';
};

std::optional<Conversion> conversionAt(std::string_view pattern, size_t begin) {
  Conversion found;
  found.begin = begin;
  size_t at = begin + 1;
  if (at < pattern.size() && pattern[at] == '0') found.zeros = true;
  while (at < pattern.size() && pattern[at] >= '0' && pattern[at] <= '9') {
    found.width = found.width * 10 + (pattern[at++] - '0');
    if (found.width > kMaxWidth) return std::nullopt;
  }
  if (at >= pattern.size() || std::string_view("diuxX").find(pattern[at]) == std::string_view::npos)
    return std::nullopt;
  found.kind = pattern[at];
  found.end = at + 1;
  return found;
}

// nullopt unless there is exactly one. Two percent signs stand for one.
std::optional<Conversion> onlyConversion(std::string_view pattern) {
  std::optional<Conversion> found;
  for (size_t at = pattern.find('%'); at != std::string_view::npos; at = pattern.find('%', at)) {
    if (pattern.substr(at, 2) == "%%") {
      at += 2;
      continue;
    }
    const std::optional<Conversion> next = conversionAt(pattern, at);
    if (!next || found) return std::nullopt;
    found = next;
    at = next->end;
  }
  return found;
}

std::string withoutDoubledPercent(std::string_view text) {
  std::string plain;
  for (size_t i = 0; i < text.size(); ++i) {
    plain += text[i];
    if (text.substr(i, 2) == "%%") ++i;
  }
  return plain;
}

std::string formatted(const Conversion& form, int64_t number) {
  std::string digits = form.kind == 'x'   ? fmt::format("{:x}", number)
                       : form.kind == 'X' ? fmt::format("{:X}", number)
                                          : fmt::format("{}", number);
  const size_t width = static_cast<size_t>(form.width);
  if (digits.size() < width) {
    const bool negative = form.zeros && number < 0;
    digits.insert(negative ? 1 : 0, width - digits.size(), form.zeros ? '0' : ' ');
  }
  return digits;
}

void demandPlainName(const std::string& path, std::string_view name) {
  bool plain = !name.empty();
  for (const char c : name) plain = plain && static_cast<unsigned char>(c) >= ' ' && c != '\x7f';
  if (!plain) fail("{}: {} is no name of a data file", path, inQuotes(name));
}

}  // namespace

int64_t FileSet::count() const {
  return pattern.empty() ? static_cast<int64_t>(names.size()) : (last - first) / step + 1;
}

std::string FileSet::name(int64_t index) const {
  if (pattern.empty()) return names[static_cast<size_t>(index)];
  const Conversion form = onlyConversion(pattern).value();
  const std::string_view view = pattern;
  return withoutDoubledPercent(view.substr(0, form.begin)) + formatted(form, first + index * step) +
         withoutDoubledPercent(view.substr(form.end));
}

FileSet parseFilePattern(const std::string& path, std::string_view pattern, std::string_view first,
                         std::string_view last, std::string_view step) {
  demandPlainName(path, pattern);
  FileSet files;
  files.pattern = pattern;
  if (!onlyConversion(pattern))
    fail("{}: the file name pattern {} needs exactly one number such as %d or %03d", path,
         inQuotes(pattern));
  const auto number = [&](std::string_view text) {
    const std::optional<int64_t> value = parseInteger(text);
    if (!value || *value > kMaxNumber || *value < -kMaxNumber)
      fail("{}: {} in the file name pattern is no whole number", path, inQuotes(text));
    return *value;
  };
  files.first = number(first);
  files.last = number(last);
  files.step = number(step);
  const bool backwards = files.last < files.first;
  if (files.step == 0 || (files.last != files.first && backwards != (files.step < 0)))
    fail("{}: the file numbers never get from {} to {} in steps of {}", path, files.first,
         files.last, files.step);
  return files;
}

void addFileName(const std::string& path, std::string_view name, FileSet& files) {
  demandPlainName(path, name);
  files.names.emplace_back(name);
}

}  // namespace sluice

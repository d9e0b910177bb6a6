#include "src/base/field_names.h"

#include <algorithm>
#include <array>

namespace sluice {
namespace {

struct Rewording {
  std::string_view option, field;
};

// Alternatives that a program with these headers does not have. They come first.
constexpr std::array kPhrases = std::to_array<Rewording>({
    {" with --gl auto", ""},
    {" or a smaller --size", " or a smaller picture"},
    {"; give --device cpu", "; let the CPU draw (device)"},
});

bool isOfWord(char c) {
  return (c >= 'a' && c <= 'z') || c == '-';
}

// Options stand at the beginning, after a space or after a bracket; "--" within a file's name is
// left alone.
bool beginsOption(std::string_view line, size_t at) {
  constexpr std::string_view kBefore = " (";
  return line.substr(at).starts_with("--") &&
         (at == 0 || kBefore.find(line[at - 1]) < kBefore.size());
}

}  // namespace

std::string renamed(std::string_view line,
                    const std::function<std::string(std::string_view option)>& nameOf) {
  std::string given(line);
  // Phrases go before the options in them are replaced one by one.
  for (const Rewording& phrase : kPhrases)
    for (size_t at = 0; (at = given.find(phrase.option, at)) != std::string::npos;
         at += phrase.field.size())
      given.replace(at, phrase.option.size(), phrase.field);

  std::string result;
  for (size_t at = 0; at < given.size();) {
    if (!beginsOption(given, at)) {
      result += given[at++];
      continue;
    }
    const auto begin = given.begin() + static_cast<std::ptrdiff_t>(at);
    const std::string option(begin, std::find_if_not(begin, given.end(), isOfWord));
    result += nameOf(option);
    at += option.size();
  }
  return result;
}

std::string lineInOptions(const std::exception& error) {
  const auto* field_error = dynamic_cast<const FieldError*>(&error);
  return field_error != nullptr ? field_error->lineInOptions() : error.what();
}

}  // namespace sluice

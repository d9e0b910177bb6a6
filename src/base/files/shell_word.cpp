#include "src/base/files/shell_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>

namespace sluice {
namespace {

// Bytes of the UTF-8 character that `text` begins with; 0: it begins with none (Unicode 15,
// table 3-7).
size_t characterBytes(std::string_view text) {
  const auto byte = [&](size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const size_t count = first >= 0xf5   ? 0
                       : first >= 0xf0 ? 4
                       : first >= 0xe0 ? 3
                       : first >= 0xc2 ? 2
                                       : 0;
  for (size_t i = 1; i < count; ++i)
    if ((byte(i) & 0xc0U) != 0x80) return 0;
  // Overlong forms, surrogates, and codes beyond the last character.
  if ((first == 0xe0 && byte(1) < 0xa0) || (first == 0xed && byte(1) > 0x9f) ||
      (first == 0xf0 && byte(1) < 0x90) || (first == 0xf4 && byte(1) > 0x8f))
    return 0;
  return count;
}

// C0 and C1 controls, DEL, line and paragraph separators, and the marks of bidirectional text.
bool isControl(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first < 0x20 || first == 0x7f;
  if (character.size() == 2)
    return first == 0xc2 && static_cast<unsigned char>(character[1]) < 0xa0;
  return (character >= "\u200e" && character <= "\u200f") ||
         (character >= "\u2028" && character <= "\u202e") ||
         (character >= "\u2066" && character <= "\u2069");
}

std::string escaped(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) {
    if (c == '\n')
      text += "\\n";
    else if (c == '\t')
      text += "\\t";
    else if (c == '\r')
      text += "\\r";
    else
      text += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  }
  return text;
}

// plain(piece) for each character that may be shown, hidden(piece) for each that may not.
template <class Plain, class Hidden>
void eachCharacter(std::string_view text, const Plain& plain, const Hidden& hidden) {
  while (!text.empty()) {
    const size_t count = characterBytes(text);
    const std::string_view piece = text.substr(0, std::max<size_t>(count, 1));
    if (count == 0 || isControl(piece))
      hidden(piece);
    else
      plain(piece);
    text.remove_prefix(piece.size());
  }
}

bool hasControls(std::string_view text) {
  bool found = false;
  eachCharacter(
      text, [](std::string_view) {}, [&](std::string_view) { found = true; });
  return found;
}

// A hexadecimal escape takes at most two digits in bash, zsh and ksh alike, but in ksh as many as
// follow: three octal digits end everywhere.
std::string escapedWord(std::string_view word) {
  std::string quoted = "$'";
  eachCharacter(
      word,
      [&](std::string_view piece) {
        if (piece == "'" || piece == "\\") quoted += '\\';
        quoted += piece;
      },
      [&](std::string_view piece) {
        for (const char c : piece)
          quoted += c == '\n' ? std::string("\\n")
                              : fmt::format("\\{:03o}", static_cast<unsigned char>(c));
      });
  return quoted + "'";
}

}  // namespace

std::string shellWord(std::string_view word) {
  const bool is_plain = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           // These mean nothing to any shell.
           std::string_view("-_./,:=+%@").find(c) != std::string_view::npos;
  });
  if (is_plain) return std::string(word);
  if (hasControls(word)) return escapedWord(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string shownName(std::string_view name) {
  return hasControls(name) ? escapedWord(name) : std::string(name);
}

std::string withoutControls(std::string_view text, std::string_view kept) {
  std::string shown;
  eachCharacter(
      text, [&](std::string_view piece) { shown += piece; },
      [&](std::string_view piece) {
        shown += kept.find(piece) != std::string_view::npos ? std::string(piece) : escaped(piece);
      });
  return shown;
}

}  // namespace sluice

#include "src/base/looks/label_look.h"

#include <fmt/format.h>

#include <cmath>

#include "src/base/files/number_text.h"
#include "src/base/looks/color_word.h"

namespace sluice {
namespace {

constexpr std::string_view kAll = "all";

// "3", "3-7", "-2", "all".
bool readLabels(std::string_view text, LabelLook& look) {
  if (text == kAll) return true;
  // A hyphen in front is a sign.
  const size_t hyphen = text.empty() ? text.npos : text.find('-', 1);
  const auto first = numberOf(text.substr(0, hyphen));
  const auto last = hyphen == text.npos ? first : numberOf(text.substr(hyphen + 1));
  if (!first || !last || *first > *last) return false;
  // Labels are whole numbers.
  if (*first != std::floor(*first) || *last != std::floor(*last)) return false;
  look.first = *first;
  look.last = *last;
  return true;
}

}  // namespace

std::optional<LabelLook> parseLabelLook(std::string_view text) {
  LabelLook look;
  const size_t equals = text.find('=');
  if (equals == text.npos || !readLabels(text.substr(0, equals), look)) return std::nullopt;
  const std::string_view rest = text.substr(equals + 1);
  const size_t colon = rest.find(':');
  look.color = rest.substr(0, colon);
  if (!look.color.empty() && !isColorWord(look.color)) return std::nullopt;
  if (colon == rest.npos) return look.color.empty() ? std::nullopt : std::optional(look);
  look.opacity = numberOf(rest.substr(colon + 1));
  if (!look.opacity || *look.opacity < 0 || *look.opacity > 1) return std::nullopt;
  return look;
}

std::string labelLookText(const LabelLook& look) {
  std::string text(kAll);
  if (std::isfinite(look.first) || std::isfinite(look.last)) {
    text = fmt::format("{}", look.first);
    if (look.last != look.first) text += fmt::format("-{}", look.last);
  }
  text += "=" + look.color;
  if (look.opacity) text += fmt::format(":{}", *look.opacity);
  return text;
}

}  // namespace sluice

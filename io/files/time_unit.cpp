#include "io/files/time_unit.h"

#include <algorithm>
#include <initializer_list>
#include <iterator>

#include "src/base/files/json_field.h"
#include "src/base/values/letter_case.h"
#include "src/base/values/text_parts.h"

namespace sluice {
namespace {

struct TimeUnit {
  std::string_view name;
  std::initializer_list<std::string_view> symbols, words;
};

// The micro sign and the Greek letter as UTF-8 and Latin-1, and as the escapes that ImageJ writes.
const TimeUnit kTimeUnits[] = {
    {"yottasecond", {"Ys"}, {}},
    {"zettasecond", {"Zs"}, {}},
    {"exasecond", {"Es"}, {}},
    {"petasecond", {"Ps"}, {}},
    {"terasecond", {"Ts"}, {}},
    {"gigasecond", {"Gs"}, {}},
    {"megasecond", {"Ms"}, {}},
    {"kilosecond", {"ks"}, {}},
    {"hectosecond", {"hs"}, {}},
    {"second", {"s"}, {"sec", "secs", "seconds"}},
    {"decisecond", {"ds"}, {}},
    {"centisecond", {"cs"}, {}},
    {"millisecond", {"ms"}, {"msec", "milliseconds"}},
    {"microsecond",
     {"us", "\xc2\xb5s", "\xce\xbcs", "\xb5s", "\\u00B5s", "\\u00b5s"},
     {"usec", "microseconds"}},
    {"nanosecond", {"ns"}, {"nsec", "nanoseconds"}},
    {"picosecond", {"ps"}, {"picoseconds"}},
    {"femtosecond", {"fs"}, {}},
    {"attosecond", {"as"}, {}},
    {"zeptosecond", {"zs"}, {}},
    {"yoctosecond", {"ys"}, {}},
    {"minute", {}, {"min", "mins", "minutes"}},
    {"hour", {"h"}, {"hr", "hours"}},
    {"day", {"d"}, {"days"}},
};

bool isAmong(std::initializer_list<std::string_view> spellings, std::string_view text) {
  return std::find(spellings.begin(), spellings.end(), text) != spellings.end();
}

}  // namespace

std::string timeUnit(std::string_view said) {
  const std::string_view text = trimmed(said);
  const std::string lower = lowercase(text);
  for (const TimeUnit& unit : kTimeUnits)
    if (isAmong(unit.symbols, text) || unit.name == lower || isAmong(unit.words, lower))
      return std::string(unit.name);
  return printable(text);
}

}  // namespace sluice

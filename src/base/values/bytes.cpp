#include "src/base/values/bytes.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "src/base/values/letter_case.h"

namespace sluice {

namespace {

// The power of 1024 that a unit stands for: "" and "B" 0, "k", "KB" and "KiB" 1; -1 when none.
int powerOf(std::string_view unit) {
  if (unit.empty()) return 0;
  std::string lower = lowercase(unit);
  const size_t power = std::string_view("bkmgt").find(lower.front());
  if (power == std::string_view::npos) return -1;
  lower.erase(0, 1);
  const bool whole = lower.empty() || (power > 0 && (lower == "b" || lower == "ib"));
  return whole ? static_cast<int>(power) : -1;
}

}  // namespace

std::optional<uint64_t> parseBytes(std::string_view text) {
  constexpr auto kMost = static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
  const char* const end = text.data() + text.size();
  if (text.starts_with('-')) return std::nullopt;
  const auto rest = [&](const char* from) {
    return std::string_view(from, static_cast<size_t>(end - from));
  };
  // Whole numbers are parsed apart: a double has only 53 bits for them.
  uint64_t whole = 0;
  const auto [whole_end, whole_status] = std::from_chars(text.data(), end, whole);
  if (whole_status == std::errc() && powerOf(rest(whole_end)) >= 0) {
    const int shift = 10 * powerOf(rest(whole_end));
    if (whole > kMost >> shift) return std::nullopt;
    return whole << shift;
  }
  double number = 0;
  const auto [number_end, status] = std::from_chars(text.data(), end, number);
  if (status != std::errc() || !(number >= 0)) return std::nullopt;
  const int power = powerOf(rest(number_end));
  if (power < 0) return std::nullopt;
  const double bytes = std::ldexp(number, 10 * power);
  // NaN fails, too.
  if (!(bytes < std::ldexp(1.0, 63))) return std::nullopt;
  return static_cast<uint64_t>(bytes);
}

std::string formatBytes(uint64_t bytes) {
  if (bytes < 1024) return fmt::format("{} B", bytes);
  constexpr std::array<const char*, 6> kUnits = {"KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  double value = static_cast<double>(bytes) / 1024;
  size_t unit = 0;
  // 1023.95 would be printed as 1024.0.
  while (value >= 1023.95 && unit + 1 < kUnits.size()) {
    value /= 1024;
    ++unit;
  }
  return fmt::format("{:.1f} {}", value, kUnits[unit]);
}

}  // namespace sluice

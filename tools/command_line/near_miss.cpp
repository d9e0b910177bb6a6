#include "tools/command_line/near_miss.h"

#include <algorithm>

#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

std::string withoutDashes(const std::string& word) {
  const size_t first = word.find_first_not_of('-');
  return first == std::string::npos ? "" : word.substr(first);
}

}  // namespace

size_t editDistance(const std::string& one, const std::string& other) {
  const std::string a = lowercase(one), b = lowercase(other);
  // Row i holds the distances of a's first i letters to all beginnings of b.
  std::vector<size_t> before_last, last, row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    before_last = std::move(last);
    last = row;
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::string nearest(const std::string& given, const std::vector<std::string>& known) {
  constexpr size_t kLongest = 64;  // nobody mistypes more, and the distance is quadratic
  constexpr size_t kLeastPart = 3;
  const std::string word = withoutDashes(given);
  if (word.empty() || word.size() > kLongest) return "";
  std::string best;
  // About a letter in three may be wrong; more would suggest words that nobody meant.
  size_t least = std::max<size_t>(1, (word.size() + 1) / 3) + 1;
  for (const std::string& candidate : known) {
    const size_t distance = editDistance(word, withoutDashes(candidate));
    if (distance >= least) continue;
    least = distance;
    best = candidate;
  }
  if (!best.empty() || word.size() < kLeastPart) return best;
  for (const std::string& candidate : known) {
    const std::string name = withoutDashes(candidate);
    if (name.starts_with(word)) return candidate;
    if (name.size() >= kLeastPart && word.find(name) != std::string::npos) return candidate;
  }
  return "";
}

}  // namespace sluice

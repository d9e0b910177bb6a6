#include "tools/bench/volumes_bench.h"

#include <algorithm>

#include "src/base/error.h"
#include "tools/command_line/parse.h"

namespace sluice {

std::pair<std::string, std::optional<double>> splitThreshold(const std::string& word,
                                                             std::optional<double> threshold) {
  const size_t at = word.rfind('@');
  if (at == std::string::npos) return {word, threshold};
  const auto number = parseNumbers(word.substr(at + 1), 1);
  if (!number) return {word, threshold};
  return {word.substr(0, at), number->front()};
}

double median(std::vector<double> values) {
  SLUICE_CHECK(!values.empty());
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace sluice

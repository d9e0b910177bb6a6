#include "src/visibility/plenoptic/series_opacity.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// The whole content of a function, for finding equal ones.
std::string keyOf(const OpacityFunction& function) {
  std::string key(1, static_cast<char>(function.floor));
  key += static_cast<char>(function.ratios.empty() ? 0 : 1);
  key.append(function.ratios.begin(), function.ratios.end());
  // The count keeps apart functions whose parts and detail would run together alike.
  key += std::to_string(function.parts.size()) + ":";
  key.append(function.parts.begin(), function.parts.end());
  key.append(function.detail.begin(), function.detail.end());
  return key;
}

}  // namespace

int32_t SeriesOpacity::functionAt(int64_t block, int64_t step) const {
  const auto of_block = spansOf(block);
  const auto behind =
      std::upper_bound(of_block.begin(), of_block.end(), step,
                       [](int64_t at, const CoherentSpan& span) { return at < span.first; });
  // Each block has a span that begins at step 0.
  SLUICE_CHECK(behind != of_block.begin());
  return (behind - 1)->function;
}

uint64_t SeriesOpacity::bytes() const {
  uint64_t sum = spans.size() * sizeof(CoherentSpan) + first_span.size() * sizeof(uint32_t);
  for (const OpacityFunction& function : functions) sum += function.bytes();
  return sum + (tree ? tree->bytes() : 0);
}

void gather(SeriesOpacity& series, std::vector<BlockOpacity> blocks) {
  SLUICE_CHECK_EQ(static_cast<int64_t>(blocks.size()), series.blockCount());
  // Equal functions are kept once: blocks of one value, and those that stay, have many.
  std::unordered_map<std::string, int32_t> known;
  std::vector<std::vector<int32_t>> begins(blocks.size());
  series.functions.clear();
  series.spans.clear();
  series.first_span.assign(1, 0);
  for (size_t b = 0; b < blocks.size(); ++b) {
    for (const CoherentSpan& span : blocks[b].spans) {
      OpacityFunction& function = blocks[b].functions[static_cast<size_t>(span.function)];
      const auto [at, is_new] =
          known.try_emplace(keyOf(function), static_cast<int32_t>(series.functions.size()));
      if (is_new) series.functions.push_back(std::move(function));
      series.spans.push_back({span.first, at->second});
      if (span.first > 0) begins[b].push_back(span.first);
    }
    series.first_span.push_back(static_cast<uint32_t>(series.spans.size()));
    // Freed at once, because all blocks of a series are many.
    blocks[b] = {};
  }
  series.tree.emplace(series.grid, series.steps, begins);
}

SeriesOpacity combined(std::span<const SeriesOpacity* const> bases,
                       std::span<const double> exponents) {
  SLUICE_CHECK_EQ(bases.size(), exponents.size());
  SLUICE_CHECK(!bases.empty());
  const SeriesOpacity& first = *bases.front();
  SeriesOpacity result;
  result.dims = first.dims;
  result.grid = first.grid;
  result.block_cells = first.block_cells;
  result.part_cells = first.part_cells;
  result.steps = first.steps;
  result.directions = first.directions;
  for (const SeriesOpacity* basis : bases)
    SLUICE_CHECK(basis->dims == first.dims && basis->block_cells == first.block_cells &&
                 basis->part_cells == first.part_cells && basis->steps == first.steps &&
                 basis->directions == first.directions);
  std::vector<BlockOpacity> blocks(static_cast<size_t>(first.blockCount()));
  for (int64_t b = 0; b < first.blockCount(); ++b) {
    // A span of the combination begins wherever one of a basis does.
    std::set<int32_t> begins{0};
    for (size_t i = 0; i < bases.size(); ++i)
      // A basis with exponent 0 does not change the combination, and neither do its spans.
      if (exponents[i] > 0)
        for (const CoherentSpan& span : bases[i]->spansOf(b)) begins.insert(span.first);
    BlockOpacity& block = blocks[static_cast<size_t>(b)];
    for (const int32_t begin : begins) {
      std::vector<const OpacityFunction*> functions;
      for (const SeriesOpacity* basis : bases)
        functions.push_back(&basis->functions[static_cast<size_t>(basis->functionAt(b, begin))]);
      block.spans.push_back({begin, static_cast<int32_t>(block.functions.size())});
      block.functions.push_back(combined(
          functions, std::vector<double>(exponents.begin(), exponents.end()), result.cubesOf(b)));
    }
  }
  gather(result, std::move(blocks));
  return result;
}

}  // namespace sluice

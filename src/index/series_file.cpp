#include "src/index/series_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "src/base/files/byte_stream.h"
#include "src/base/values/fnv1a.h"

namespace sluice {
namespace {

struct SeriesHeader {
  int64_t dims[3];
  int64_t size, ghost, steps, part_cells, direction_rows, detail_bits;
  double difference;
  friend bool operator==(const SeriesHeader&, const SeriesHeader&) = default;
};

// The fields that differ if functions were made from other voxels, blocks or parameters.
SeriesHeader headerOf(const SeriesRecipe& recipe) {
  const BlockLayout& layout = recipe.layout;
  return {{layout.dims.x, layout.dims.y, layout.dims.z},
          layout.size,
          layout.ghost,
          recipe.steps,
          recipe.part_cells,
          recipe.directions.rows,
          recipe.detail_bits,
          recipe.difference};
}

void write(ByteWriter& out, const TransferFunction& transfer) {
  // Colours do not count: functions follow from opacities alone.
  out.list(transfer.opacities);
  out.value<uint8_t>(transfer.labels ? 1 : 0);
  out.value(static_cast<uint32_t>(transfer.gradients.size()));
  for (const GradientRow& row : transfer.gradients) {
    out.value(row.magnitude);
    out.list(row.factors);
  }
}

bool read(ByteReader& in, TransferFunction& transfer) {
  uint8_t labels = 0;
  uint32_t rows = 0;
  if (!in.list(transfer.opacities) || !in.value(labels) || !in.value(rows)) return false;
  // No transfer function has more rows: a damaged number must not claim memory.
  if (transfer.opacities.empty() || rows > kMostGradientRows) return false;
  transfer.labels = labels != 0;
  transfer.gradients.resize(rows);
  for (GradientRow& row : transfer.gradients)
    if (!in.value(row.magnitude) || !in.list(row.factors) || row.factors.empty()) return false;
  return true;
}

// Small numbers in few bytes: seven bits each, the last without the eighth.
void pack(std::vector<uint8_t>& out, uint64_t v) {
  for (; v >= 128; v >>= 7) out.push_back(static_cast<uint8_t>(v | 128));
  out.push_back(static_cast<uint8_t>(v));
}

class Unpacker {
 public:
  explicit Unpacker(const std::vector<uint8_t>& bytes) : bytes_(bytes) {}
  bool value(uint64_t& v) {
    v = 0;
    // At most nine bytes: more would shift bits out of the number.
    for (unsigned shift = 0; shift < 63 && at_ < bytes_.size(); shift += 7) {
      const uint8_t byte = bytes_[at_++];
      v |= uint64_t{byte & 127U} << shift;
      if (byte < 128) return true;
    }
    return false;
  }
  bool byte(uint8_t& v) {
    if (at_ >= bytes_.size()) return false;
    v = bytes_[at_++];
    return true;
  }
  bool list(std::vector<uint8_t>& to) {
    uint64_t count = 0;
    if (!value(count) || count > bytes_.size() - at_) return false;
    to.assign(bytes_.begin() + static_cast<ptrdiff_t>(at_),
              bytes_.begin() + static_cast<ptrdiff_t>(at_ + count));
    at_ += count;
    return true;
  }
  bool atEnd() const { return at_ == bytes_.size(); }

 private:
  const std::vector<uint8_t>& bytes_;
  size_t at_ = 0;
};

std::vector<uint8_t> packFunctions(const SeriesOpacity& series) {
  std::vector<uint8_t> out;
  for (const OpacityFunction& function : series.functions) {
    out.push_back(function.floor);
    for (const std::vector<uint8_t>* table :
         {&function.ratios, &function.parts, &function.detail}) {
      pack(out, table->size());
      out.insert(out.end(), table->begin(), table->end());
    }
  }
  return out;
}

bool unpackFunctions(const std::vector<uint8_t>& bytes, uint64_t count, SeriesOpacity& series) {
  Unpacker in(bytes);
  // Each function takes a byte at least, so that the count cannot claim more memory than the file
  // has.
  if (count > bytes.size()) return false;
  for (uint64_t i = 0; i < count; ++i) {
    OpacityFunction function;
    // Lookups do not check bounds again, so that each table must have the size that its block gives
    // it.
    if (!in.byte(function.floor) || !in.list(function.ratios) || !in.list(function.parts) ||
        !in.list(function.detail) || !detailFits(function.parts, function.detail))
      return false;
    const auto cells = static_cast<size_t>(series.directions.count());
    if (!function.ratios.empty() && function.ratios.size() != cells) return false;
    series.functions.push_back(std::move(function));
  }
  return in.atEnd();
}

// Each block gives the number of its spans. Each span gives the steps since the last one began, and
// its function.
std::vector<uint8_t> packSpans(const SeriesOpacity& series) {
  std::vector<uint8_t> out;
  for (int64_t block = 0; block < series.blockCount(); ++block) {
    const auto spans = series.spansOf(block);
    pack(out, spans.size());
    int32_t last = 0;
    for (const CoherentSpan& span : spans) {
      pack(out, static_cast<uint64_t>(span.first - last));
      pack(out, static_cast<uint64_t>(span.function));
      last = span.first;
    }
  }
  return out;
}

bool fitsBlock(const SeriesOpacity& series, int64_t block, uint64_t function) {
  if (function >= series.functions.size()) return false;
  // A function without parts is its floor everywhere. Another one must have as many as the block.
  const size_t parts = series.functions[function].parts.size();
  return parts == 0 || parts == static_cast<size_t>(volume(series.partsOf(block).count()));
}

bool unpackSpans(const std::vector<uint8_t>& bytes, SeriesOpacity& series,
                 std::vector<std::vector<int32_t>>& begins) {
  Unpacker in(bytes);
  series.first_span.assign(1, 0);
  for (int64_t block = 0; block < series.blockCount(); ++block) {
    uint64_t count = 0;
    if (!in.value(count) || count < 1 || count > static_cast<uint64_t>(series.steps)) return false;
    std::vector<int32_t>& of_block = begins[static_cast<size_t>(block)];
    int64_t at = 0;
    for (uint64_t i = 0; i < count; ++i) {
      uint64_t later = 0, function = 0;
      if (!in.value(later) || !in.value(function) || !fitsBlock(series, block, function))
        return false;
      // The first span of a block begins at step 0, and each other one later.
      if ((i == 0) != (later == 0) || later >= static_cast<uint64_t>(series.steps - at))
        return false;
      at += static_cast<int64_t>(later);
      series.spans.push_back({static_cast<int32_t>(at), static_cast<int32_t>(function)});
      // Spans that begin after step 0 are the tree's.
      if (at > 0) of_block.push_back(static_cast<int32_t>(at));
    }
    series.first_span.push_back(static_cast<uint32_t>(series.spans.size()));
  }
  return in.atEnd();
}

bool unpackSeries(ByteReader& in, const SeriesRecipe& recipe, SeriesOpacity& series) {
  const BlockLayout& layout = recipe.layout;
  series.dims = layout.dims;
  series.grid = layout.grid;
  series.block_cells = layout.cells();
  series.part_cells = recipe.part_cells;
  series.steps = recipe.steps;
  series.directions = recipe.directions;
  uint64_t functions = 0;
  std::vector<uint8_t> packed;
  if (!in.value(functions) || !in.list(packed) || !unpackFunctions(packed, functions, series))
    return false;
  // Every block has a span of two bytes at the least: no more blocks than that are believed.
  if (!in.list(packed) || static_cast<int64_t>(packed.size() / 2) < layout.blockCount())
    return false;
  std::vector<std::vector<int32_t>> begins(static_cast<size_t>(layout.blockCount()));
  std::vector<uint64_t> bits;
  if (!unpackSpans(packed, series, begins) || !in.list(bits)) return false;
  // The tree follows from the spans, so that a tree that differs is of other spans.
  series.tree.emplace(series.grid, series.steps, begins);
  return std::ranges::equal(series.tree->bits(), bits);
}

std::vector<std::byte> bytesOf(const TransferFunction& transfer) {
  ByteWriter out;
  write(out, transfer);
  return std::move(out.bytes);
}

}  // namespace

bool sameOpacity(const TransferFunction& a, const TransferFunction& b) {
  return bytesOf(a) == bytesOf(b);
}

IndexKey seriesKey(const VolumeSource& source, const SeriesRecipe& recipe) {
  const BlockLayout& layout = recipe.layout;
  // The hash only makes the key's name. The transfer function itself is in the file and compared
  // there.
  return {source.identity(),
          fmt::format("opacity-{}{}-{}-p{}.{}-d{}-e{}-of{}-{:016x}", layout.size,
                      layout.ghost == 0 ? "" : "-lit", selectionOf(source.layout(), 0),
                      recipe.part_cells, recipe.detail_bits, recipe.directions.rows,
                      recipe.difference, recipe.steps, fnv1a(bytesOf(recipe.transfer))),
          kSeriesVersion};
}

std::vector<std::byte> serialize(const KeptSeries& kept, const SeriesRecipe& recipe) {
  ByteWriter out;
  out.value(headerOf(recipe));
  write(out, kept.transfer);
  out.value(kept.device_range);
  out.list(kept.nonempty);
  const SeriesPassReport& report = kept.report;
  out.value(report.read_seconds);
  out.value(report.functions_seconds);
  out.value(report.fusion_seconds);
  out.value(report.tree_seconds);
  out.value(report.worker_bytes);
  out.list(report.blocks);
  out.list(report.coherent);
  const SeriesOpacity& series = kept.opacity;
  out.value<uint64_t>(series.functions.size());
  out.list(packFunctions(series));
  out.list(packSpans(series));
  out.list(std::vector<uint64_t>(series.tree->bits().begin(), series.tree->bits().end()));
  return std::move(out.bytes);
}

std::optional<KeptSeries> deserializeSeries(std::span<const std::byte> bytes,
                                            const SeriesRecipe& recipe, bool any_transfer) {
  ByteReader in(bytes);
  KeptSeries kept;
  SeriesPassReport& report = kept.report;
  SeriesHeader header{};
  if (!in.value(header) || header != headerOf(recipe)) return std::nullopt;
  if (!read(in, kept.transfer)) return std::nullopt;
  if (!any_transfer && !sameOpacity(kept.transfer, recipe.transfer)) return std::nullopt;
  if (!in.value(kept.device_range) || !in.list(kept.nonempty) || !in.value(report.read_seconds) ||
      !in.value(report.functions_seconds) || !in.value(report.fusion_seconds) ||
      !in.value(report.tree_seconds) || !in.value(report.worker_bytes) || !in.list(report.blocks) ||
      !in.list(report.coherent))
    return std::nullopt;
  const auto steps = static_cast<size_t>(recipe.steps);
  // The report counts from the second step on.
  if (kept.nonempty.size() != steps || report.blocks.size() + 1 != steps ||
      report.coherent.size() + 1 != steps)
    return std::nullopt;
  if (!unpackSeries(in, recipe, kept.opacity) || !in.left().empty()) return std::nullopt;
  return kept;
}

}  // namespace sluice

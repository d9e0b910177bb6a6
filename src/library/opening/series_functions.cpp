#include "src/library/opening/series_functions.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "src/base/error.h"
#include "src/library/opening/step_ranges.h"
#include "src/visibility/plenoptic/extinction.h"

namespace sluice {
namespace {

// A smaller exponent would hide next to nothing.
constexpr double kLeastExponent = 0.2;

SeriesRecipe recipeOf(const IndexedVolume& volume, const TransferFunction& transfer,
                      const SeriesOptions& options) {
  return {transfer,           volume.layout,      volume.source->layout().time_steps,
          options.difference, options.part_cells, {options.direction_rows},
          options.detail_bits};
}

// Names the functions that were made last, whatever their look.
IndexKey lastKey(const IndexedVolume& volume, const SeriesRecipe& recipe) {
  IndexKey key = seriesKey(*volume.source, recipe);
  // The key ends in a digest of the look, which "-last" replaces.
  key.what.resize(key.what.rfind('-'));
  key.what += "-last";
  return key;
}

OpacityTable tableOf(const TransferFunction& transfer, const IndexedVolume& volume,
                     ValueRange device_range) {
  TransferFunction colored = transfer;
  if (colored.colors.empty()) colored.colors = {{0, {1, 1, 1}}};
  return {colored, volume.map, device_range};
}

// Functions of the look itself, or of another look of the same family.
std::optional<SeriesFunctions> keptFunctions(const IndexedVolume& volume,
                                             const SeriesRecipe& recipe, bool of_others) {
  SeriesFunctions found;
  IndexRead own = readIndex(volume.places, seriesKey(*volume.source, recipe));
  found.note = std::move(own.note);
  if (own.blob) {
    if (auto kept = deserializeSeries(*own.blob, recipe)) {
      found.bytes = own.blob->size();
      found.path = std::move(own.path);
      found.kept = std::make_shared<const KeptSeries>(std::move(*kept));
      return found;
    }
  }
  if (!of_others) return std::nullopt;
  const IndexRead last = readIndex(volume.places, lastKey(volume, recipe));
  if (!last.blob) return std::nullopt;
  IndexKey key = seriesKey(*volume.source, recipe);
  // The last key is the content of this file.
  key.what.assign(reinterpret_cast<const char*>(last.blob->data()), last.blob->size());
  IndexRead other = readIndex(volume.places, key);
  if (!other.blob) return std::nullopt;
  auto kept = deserializeSeries(*other.blob, recipe, true);
  if (!kept) return std::nullopt;
  found.exponent = greatestExponent(tableOf(recipe.transfer, volume, kept->device_range),
                                    tableOf(kept->transfer, volume, kept->device_range));
  // Functions that would hide next to nothing count as none.
  if (found.exponent < kLeastExponent) return std::nullopt;
  found.bytes = other.blob->size();
  found.path = std::move(other.path);
  found.note = fmt::format(
      "uses opacity functions of another look, with an exponent of {:.3g}; run sluice prepare for "
      "functions of this look",
      found.exponent);
  found.kept = std::make_shared<const KeptSeries>(std::move(*kept));
  return found;
}

void keep(const IndexedVolume& volume, const SeriesRecipe& recipe, SeriesFunctions& made) {
  const IndexKey key = seriesKey(*volume.source, recipe);
  const std::vector<std::byte> blob = serialize(*made.kept, recipe);
  made.bytes = blob.size();
  IndexWritten written = writeIndex(volume.places, key, blob);
  made.path = std::move(written.path);
  made.origin = builtOrigin(made.path);
  if (!written.note.empty()) made.note = written.note;
  if (made.path.empty()) return;
  // Written after the functions themselves, so that it never names functions that are not there.
  writeIndex(volume.places, lastKey(volume, recipe),
             std::as_bytes(std::span(key.what.data(), key.what.size())));
}

SeriesFunctions functionsOfLook(const IndexedVolume& volume, const TransferFunction& transfer,
                                const SeriesOptions& options, const IndexPass& pass,
                                bool of_others) {
  const SeriesRecipe recipe = recipeOf(volume, transfer, options);
  if (!options.anew)
    if (auto found = keptFunctions(volume, recipe, of_others)) return std::move(*found);
  auto kept = std::make_shared<KeptSeries>();
  kept->transfer = transfer;
  kept->device_range = volume.index->ranges.device_range;
  const ExtinctionTable table(tableOf(transfer, volume, kept->device_range));
  std::vector<StepBlocks> steps;
  for (int64_t time = 0; time < recipe.steps; ++time) {
    steps.emplace_back(rangesOfStep(volume, time, pass).ranges, table);
    kept->nonempty.push_back(steps.back().nonEmpty());
  }
  SeriesPassOptions how;
  how.difference = options.difference;
  how.part_cells = options.part_cells;
  how.detail_bits = options.detail_bits;
  how.directions = recipe.directions;
  VolumePass within = pass;
  within.memory_bytes = std::min(kMostSeriesBytes, pass.memory_bytes / 4);
  kept->opacity =
      makeSeriesOpacity(*volume.source, volume.layout, steps, table, how, within, &kept->report);
  SeriesFunctions made;
  made.kept = std::move(kept);
  if (options.anew) {
    made.bytes = serialize(*made.kept, recipe).size();
    made.origin = IndexOrigin::kBuiltNotKept;
  } else {
    keep(volume, recipe, made);
  }
  return made;
}

SeriesFunctions functionsOfFamily(const IndexedVolume& volume, const TransferFunction& transfer,
                                  const SeriesOptions& options, const IndexPass& pass) {
  SeriesFunctions family;
  std::vector<SeriesFunctions> each;
  std::vector<OpacityTable> tables;
  std::vector<const SeriesOpacity*> bases;
  for (const TransferFunction& basis : options.basis) {
    each.push_back(functionsOfLook(volume, basis, options, pass, false));
    const SeriesFunctions& made = each.back();
    if (made.origin != IndexOrigin::kRead) family.origin = made.origin;
    family.path = made.path;
    if (made.path.empty()) family.note = made.note;
    family.bytes += made.bytes;
    tables.push_back(tableOf(basis, volume, made.kept->device_range));
    bases.push_back(&made.kept->opacity);
  }
  const KeptSeries& first = *each.front().kept;
  family.exponents = familyExponents(tableOf(transfer, volume, first.device_range), tables);
  if (std::ranges::all_of(family.exponents, [](double k) { return k == 0; }))
    family.note =
        "the look is not a product of powers of the basis, so nothing is culled; run sluice "
        "prepare without --basis for functions of this look";
  auto kept = std::make_shared<KeptSeries>();
  kept->transfer = transfer;
  kept->device_range = first.device_range;
  kept->nonempty = first.nonempty;
  kept->report = first.report;
  for (size_t i = 1; i < each.size(); ++i) {
    const KeptSeries& other = *each[i].kept;
    for (size_t step = 0; step < kept->nonempty.size(); ++step)
      kept->nonempty[step] = std::max(kept->nonempty[step], other.nonempty[step]);
    kept->report.read_seconds += other.report.read_seconds;
    kept->report.functions_seconds += other.report.functions_seconds;
    kept->report.fusion_seconds += other.report.fusion_seconds;
    kept->report.tree_seconds += other.report.tree_seconds;
  }
  kept->opacity = combined(bases, family.exponents);
  family.kept = std::move(kept);
  return family;
}

}  // namespace

std::vector<double> familyExponents(const OpacityTable& a, std::span<const OpacityTable> basis) {
  // Opacities are interpolated between two entries; as extinctions this gives slightly less.
  constexpr double kBetweenEntries = 0.998;
  const std::vector<float> of_a = ExtinctionTable(a).entries();
  std::vector<double> left(of_a.begin(), of_a.end()), exponents;
  for (const OpacityTable& b : basis) {
    double least = 1e9;
    if (a.entries() == b.entries() && a.deviceRange() == b.deviceRange() &&
        // Only tables over the same entries can be compared entry by entry.
        a.labels() == b.labels()) {
      const std::vector<float> of_b = ExtinctionTable(b).entries();
      for (size_t i = 0; i < left.size(); ++i)
        if (of_b[i] > 0) least = std::min(least, left[i] / static_cast<double>(of_b[i]));
      // The look itself needs no margin.
      const double k = least > 1e8 ? 0 : least == 1 ? 1 : std::max(least, 0.0) * kBetweenEntries;
      for (size_t i = 0; i < left.size(); ++i) left[i] -= k * static_cast<double>(of_b[i]);
      exponents.push_back(k);
    } else {
      exponents.push_back(0);
    }
  }
  return exponents;
}

double greatestExponent(const OpacityTable& a, const OpacityTable& b) {
  return familyExponents(a, {&b, 1}).front();
}

SeriesFunctions seriesFunctions(const IndexedVolume& volume, const TransferFunction& transfer,
                                const SeriesOptions& options, const IndexPass& pass) {
  return options.basis.empty() ? functionsOfLook(volume, transfer, options, pass, true)
                               : functionsOfFamily(volume, transfer, options, pass);
}

std::optional<SeriesFunctions> keptSeriesFunctions(const IndexedVolume& volume,
                                                   const TransferFunction& transfer,
                                                   const SeriesOptions& options,
                                                   const IndexPass& pass) {
  if (options.basis.empty())
    return keptFunctions(volume, recipeOf(volume, transfer, options), true);
  for (const TransferFunction& basis : options.basis)
    if (!keptFunctions(volume, recipeOf(volume, basis, options), false)) return std::nullopt;
  return functionsOfFamily(volume, transfer, options, pass);
}

}  // namespace sluice

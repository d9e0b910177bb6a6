// SeriesFunctions: the opacity functions of a series for the look that it is drawn with, from its
// index if they are there, otherwise made and kept there; and the time steps as they are drawn with
// them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/index/series_file.h"
#include "src/library/opening/indexed_volume.h"

namespace sluice {

struct SeriesOptions {
  double difference = 0.001;  // see SeriesPassOptions
  int64_t part_cells = 4;
  int direction_rows = 4;
  int detail_bits = kMostDetailBits;  // see part_detail.h
  // Functions are made for each of these and put together for the look (equation 4), so that other
  // looks of the same family need none. Empty: they are made for the look itself.
  std::vector<TransferFunction> basis = {};
  bool anew = false;  // not read from the index, and not kept in it
};

struct SeriesFunctions {
  std::shared_ptr<const KeptSeries> kept;
  // The exponents of a basis, one for each of its functions; these are in `kept`.
  std::vector<double> exponents = {};
  // The look's extinction is at least this times the extinction of the functions' transfer function
  // (Gao 2004, equation 4, of a basis of one): 1 if it is the same.
  double exponent = 1;
  IndexOrigin origin = IndexOrigin::kRead;
  std::filesystem::path path;  // empty if none is kept
  uint64_t bytes = 0;          // size of the file, or the size that it would have
  std::string note;            // for people; empty: none

  SeriesOpacityPtr opacity() const { return {kept, &kept->opacity}; }
};

// Requires a volume that was opened for the whole series (IndexNeeds). `transfer` is the look's. If
// the index has functions of another look whose opacity is nowhere greater than this one's, they
// serve: opacity edits need no new pass. Otherwise all steps are read, once for the min-max arrays
// if these are missing, and once more. Throws Error, which names the step's file, Interrupted.
SeriesFunctions seriesFunctions(const IndexedVolume& volume, const TransferFunction& transfer,
                                const SeriesOptions& options, const IndexPass& pass);

// The same where nothing needs to be made: nullopt if the index lacks functions of the look.
std::optional<SeriesFunctions> keptSeriesFunctions(const IndexedVolume& volume,
                                                   const TransferFunction& transfer,
                                                   const SeriesOptions& options,
                                                   const IndexPass& pass);

// The greatest k for which (1 - b)^k is nowhere less than 1 - a, with a and b the opacities of the
// tables; 0 if the tables cannot be compared.
double greatestExponent(const OpacityTable& a, const OpacityTable& b);
// Exponents for which the product of all (1 - b)^k is nowhere less than 1 - a: the greatest for the
// first of the basis, then for the second with the remainder, and so on. 0 for those that add
// nothing or cannot be compared.
std::vector<double> familyExponents(const OpacityTable& a, std::span<const OpacityTable> basis);

}  // namespace sluice

// Agreement: ranks draw one picture together, so all of them must draw the same volume the same
// way. Each rank states facts; a rank whose facts differ from rank 0's ends the run with one line.
// Without this check the picture is a mixture, and nobody notices.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/parallel/communication/team.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// A fact in a rank's statement: "--block" is "32". `value` is printed; data too large to print is
// compared by its digest.
struct Fact {
  std::string name;
  std::string value;
  uint64_t digest = 0;
};

// Returns if every rank states the same facts; their order makes no difference. Otherwise throws
// Error at every rank, the same line at each: the first rank that differs from rank 0, the
// difference, and that rank's `advice`. All ranks call it. Throws RankFailed and Interrupted too.
void expectAgreement(Team& team, const std::vector<Fact>& facts, std::string_view advice);

// The contents of a time step of a volume, as far as they can be told quickly: its shape and type,
// the min-max arrays, which depend on every voxel, and `samples` rows of voxels. The rows find a
// copy that has changed although its index has not. Throws Error as the source does.
std::vector<Fact> factsOf(VolumeSource& source, int64_t time, const SliceRanges& ranges,
                          int samples);

}  // namespace sluice

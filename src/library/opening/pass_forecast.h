// PassForecast: what the first opening of a volume for a picture will read of a store of chunks,
// told from its metadata alone.
//
// A volume without an index is passed over: whole, or, if it has levels of resolution that pictures
// may be drawn from, at a coarse level that stands in (stand_in.h). On a disk that costs time. On a
// server it may cost gigabytes, so that `plan` tells it beforehand.
#pragma once

#include <optional>

#include "src/base/sources/stored_reads.h"
#include "src/library/opening/indexed_volume.h"

namespace sluice {

struct PassForecast {
  int level = 0;        // the one that is read for the values of the picture
  bool is_all = false;  // it is level 0: nothing is known of the picture before
  StoredReads reads;    // of that level, and of others that need an index
};

// nullopt: the volume has its index, or is no store of chunks. `needs`: as indexVolume() takes
// them. No voxel is read. Throws Error as opening does.
std::optional<PassForecast> passForecast(VolumeSource& source, const VolumeArguments& arguments,
                                         const MachineOptions& machine, const IndexNeeds& needs,
                                         const IndexWish& wish);

}  // namespace sluice

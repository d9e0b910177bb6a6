// Undoes the filters of HDF5 chunks: shuffle, Fletcher32, deflate, and of those registered with The
// HDF Group LZF (32000), Blosc (32001), LZ4 (32004) and Zstandard (32015). Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/hdf5/hdf5_module.h"

namespace sluice {

// Whether undoFilters() knows all of them.
bool areKnownFilters(std::span<const Hdf5Filter> filters);

// Fills `chunk`. `mask`: bit i is set if filter i was left out. `stored` is used as memory. Throws
// Error, which starts with `path`: damaged, or not of the chunk's size. Requires:
// areKnownFilters().
void undoFilters(std::span<const Hdf5Filter> filters, uint32_t mask, std::vector<std::byte>& stored,
                 std::span<std::byte> chunk, const std::string& path);

}  // namespace sluice

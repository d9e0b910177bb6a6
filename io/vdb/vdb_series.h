// The steps of a series of OpenVDB files in one box.
//
// A simulation writes of each step what is active then, so that the steps' boxes grow and move. As
// time steps of one volume they all fill one box of the world, the one around all of theirs. Plain
// function, any thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/stop_token.h"
#include "src/base/vec.h"

namespace sluice {

// For each file the box of its index space that openVdb() has to deliver: the same voxels of the
// world for all, the active ones of every file and one more on each side. Reads the headers of the
// files, and the tree of a file whose header does not state its box. Throws Error: as openVdb does;
// transforms that differ in more than a shift of whole voxels; no active voxels in any file;
// and Interrupted. Requires: files not empty.
std::vector<Box3> vdbSeriesBoxes(const std::vector<std::filesystem::path>& files,
                                 const std::string& grid, const StopToken& stop = {});

}  // namespace sluice

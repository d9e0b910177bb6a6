// The steps of a series of OpenVDB files in one box.
//
// A simulation writes the active part of each step, so the steps' boxes grow and move. As time
// steps of one volume, all steps deliver the same box of the world, which contains all of theirs.
// Plain function, any thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "src/base/threads/stop_token.h"
#include "src/base/values/vec.h"

namespace sluice {

// The box of each file's index space that openVdb() has to deliver: the same voxels of the world
// for all, the active ones of every file and one more on each side. Reads the headers of the files,
// and the tree of a file whose header does not state its box. Throws Error: as openVdb does;
// transforms that differ in more than a shift of whole voxels; no active voxels in any file; and
// Interrupted. Requires: files not empty.
std::vector<Box3> vdbSeriesBoxes(const std::vector<std::filesystem::path>& files,
                                 const std::string& grid, const StopToken& stop = {});

}  // namespace sluice

// Cuts through levels of resolution in reports and for people. Pure functions.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "src/classify/blocks/classification.h"
#include "src/library/drawing/scene/refined_frame.h"

namespace sluice {

// The kind of the voxels of coarser levels, in one word: "maxima".
const char* wordOf(LevelValues values);
// Levels that are drawn.
nlohmann::json cutJson(const CutSummary& cut);
// The same in one line for people.
std::string cutLine(const CutSummary& cut);
// "level 2", "levels 1, 2", and whether the picture will improve, for people.
std::string refinedLine(const CutSummary& cut);
// `cut`, `seconds` and `step` of each picture of a frame that got better.
nlohmann::json refinedJson(const std::vector<RefinedPicture>& pictures);
// Whether anything is drawn coarser than it is stored.
bool isCoarser(const VisibleBlocks& blocks);

}  // namespace sluice

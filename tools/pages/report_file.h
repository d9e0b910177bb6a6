// --report FILE: JSON for scripts, or by the name's end a page for people.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

#include "src/base/values/picture.h"
#include "src/classify/blocks/classification.h"
#include "tools/command_line/outputs.h"
#include "tools/pages/run_page.h"

namespace sluice {

// Whether a name ends in .html or .htm, in any case.
bool isPage(const std::filesystem::path& file);
FileKind reportKind(const std::filesystem::path& file);

// Adds the map of blocks, if one can be drawn.
void addBlocks(PagePictures& pictures, Vec3i grid, const VisibleBlocks& blocks);
// Puts the picture there: of a PNG that was written its bytes, else one of `drawn`.
void addPicture(PagePictures& pictures, const std::filesystem::path& written, const Picture& drawn);

// Throws Error when the file cannot be written; an older one is then as it was.
void writeReport(const std::string& file, const nlohmann::json& report,
                 const PagePictures& pictures = {});

}  // namespace sluice

// The files of an OME-TIFF set, found beside one of them.
#pragma once

#include <filesystem>
#include <vector>

#include "io/slices/page_order.h"

namespace sluice {

// The order of a file's `pages` pages, or of the set that it belongs to, if a companion describes
// the set. Throws Error: the companion is missing, cannot be read or does not describe pixels.
PageOrder orderWithCompanion(const std::filesystem::path& file, PageOrder order, int64_t pages);

// The paths of order.files, which lie in the folder of `file`. Throws Error: one of them is
// missing, or is named by more than its name.
std::vector<std::filesystem::path> filesOfSet(const std::filesystem::path& file,
                                              const PageOrder& order);

}  // namespace sluice

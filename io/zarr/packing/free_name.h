// The name of a store that is to be written: what lies there is replaced only if it is a store and
// nothing else.
#pragma once

#include <filesystem>

namespace sluice {

// Throws Error when a store must not be written to `output`: the name does not end in .zarr, or it
// exists and is not to be replaced, is no store, or has files that are no part of one.
void requireFreeName(const std::filesystem::path& output, bool replace);

// The path of a folder, whether or not it was given with a slash at its end.
std::filesystem::path withoutSlash(const std::filesystem::path& path);

}  // namespace sluice

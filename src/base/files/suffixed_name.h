// The names of files that are written beside a user's file before it is whole. A pure function of
// the path and of the longest name that its folder allows.
#pragma once

#include <filesystem>
#include <string_view>

namespace sluice {

// `path` with `suffix` after its name. A name that would become longer than the file system allows
// is cut between two characters of UTF-8 and gets a checksum of the whole name, so that two long
// names stay two. The user's name may have any length that is allowed.
std::filesystem::path suffixedName(const std::filesystem::path& path, std::string_view suffix);

}  // namespace sluice

// Files that are costly to make and only read: made once for all test programs of a build.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace sluice {

// The folder "made/NAME" beside the test program. If it is not there yet, `make` fills it, while
// other programs that want it wait; if that returns false or throws, nothing stays, and the path is
// empty. A name must change with what it stands for.
std::filesystem::path madeOnce(const std::string& name,
                               const std::function<bool(const std::filesystem::path&)>& make);

}  // namespace sluice

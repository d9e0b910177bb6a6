// Small files that a user names for an option: a transfer function, a camera path.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "src/base/threads/stop_token.h"

namespace sluice {

// All of a file or a pipe. A pipe is waited for as long as somebody holds its other end and writes
// at least every ten seconds; one that nobody writes to is an error at once, never a wait without
// end. Throws Error, which names the path and `what` was expected: it cannot be read, is a folder,
// or holds more than `most_bytes`; and Interrupted.
std::string readTextFile(const std::filesystem::path& path, uint64_t most_bytes,
                         std::string_view what, const StopToken& stop = {});

}  // namespace sluice

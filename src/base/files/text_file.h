// Small files that a user names for an option: a transfer function, a camera path.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "src/base/threads/stop_token.h"

namespace sluice {

// All of a file or a pipe. A pipe is read as long as somebody holds its other end and writes at
// least every ten seconds. A writer may come up to three seconds late; a pipe that nobody writes to
// is then an error, never an empty text nor a wait without end. Throws Error, which names the path
// and `what` was expected: it cannot be read, is a folder, or holds more than `most_bytes`; and
// Interrupted.
std::string readTextFile(const std::filesystem::path& path, uint64_t most_bytes,
                         std::string_view what, const StopToken& stop = {});

}  // namespace sluice

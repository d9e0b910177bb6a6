// The fields of the public headers that options of the command line stand for. Messages within the
// program name options; the library's users get the same line with fields.
#pragma once

#include <string>
#include <string_view>

namespace sluice {

// "--memory 64M is too small; give --memory 96M or fewer --pages" becomes "memory_bytes 64M is too
// small; give memory_bytes 96M". An option without a field keeps its name.
std::string inFields(std::string_view line);

}  // namespace sluice

// The trace formats by a file's name, for writing.
#pragma once

#include <filesystem>

#include "cache/trace/trace.h"

namespace sluice {

// .txt text, .csv, .din, .oracleGeneral; anything else our compact binary.
TraceFormat traceFormatOf(const std::filesystem::path& path);

}  // namespace sluice

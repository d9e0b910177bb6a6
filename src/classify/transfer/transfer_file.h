// Transfer functions in files: our own JSON (docs/transfer-functions.md) and ParaView's colour
// maps.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "src/base/threads/stop_token.h"
#include "src/classify/transfer/transfer_function.h"

namespace sluice {

// Reads either kind; `range` is the volume's, over which maps and fractions are laid. `map` is the
// Name of the wanted map of a ParaView file, or else a colour map that replaces the colours of a
// file of one map. The result is valid. Throws Error: one line with the path, the field, what was
// expected and what was found; and Interrupted, while it waits for a pipe.
TransferFunction readTransferFunction(const std::filesystem::path& path, ValueRange range,
                                      std::string_view map = {}, const StopToken& stop = {});

// The same from text; `where` starts the errors and names a transfer function that has no name.
TransferFunction parseTransferFunction(std::string_view json, const std::string& where,
                                       ValueRange range, std::string_view map = {});

// Our own JSON, on one line. parseTransferFunction gives the same transfer function back, bit for
// bit, whatever the range. Requires: validate() passes.
std::string writeTransferFunction(const TransferFunction& transfer);

}  // namespace sluice

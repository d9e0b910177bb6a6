// Progress on a terminal: one line with share, rate and time left, which ends with the work done;
// silent when standard error is none. A terminal that takes nothing changes nothing.
#pragma once

#include <string>

#include "src/base/threads/progress_meter.h"

namespace sluice {

// kShare: what is done is only known as a share of the total.
enum class ProgressUnit { kBytes, kPieces, kShare };

// The line appears after half a second, and ends with the last copy of the returned function. It
// must not be called by two threads at once, as a ProgressMeter never does.
ProgressWatch progressLine(const std::string& label, ProgressUnit unit = ProgressUnit::kBytes);

}  // namespace sluice

// The processors of this process, by their numbers: ranks with the same ones share them.
#pragma once

#include <sched.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace sluice {

// Fills a set of so many bytes, as sched_getaffinity() does for this process: 0, or -1 with errno
// EINVAL if the machine has more processors than the set has room for.
using AskProcessors = std::function<int(size_t bytes, cpu_set_t* set)>;
int askSystem(size_t bytes, cpu_set_t* set);

// The numbers of the processors on which this process may run, ascending, on a machine of any size;
// empty: the system does not tell.
std::vector<int> processorsOfProcess(const AskProcessors& ask = askSystem);

}  // namespace sluice

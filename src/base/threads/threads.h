// The one place that starts threads (a gate holds the others to it). A system that gives no more of
// them (a limit on processes or on addresses) is an expected outcome: one goes on with those it
// gave.
#pragma once

#include <functional>
#include <thread>
#include <vector>

namespace sluice {

// Starts a thread that runs `body`. Throws std::system_error or std::bad_alloc if the system gives
// none.
using ThreadStarter = std::function<std::thread(const std::function<void()>& body)>;
std::thread startThread(const std::function<void()>& body);

// Up to `count` threads that run `body`: as many as could be started before the first that could
// not. Keeps addresses free meanwhile, so that a limit on them leaves some for the threads' work.
// The caller joins them.
std::vector<std::thread> startThreads(int count, const std::function<void()>& body,
                                      const ThreadStarter& start = startThread);

// How many the system would give now, up to `most`.
int startableThreads(int most);

// Processors of this machine, at least 1.
int processorCount();

}  // namespace sluice

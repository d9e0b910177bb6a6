// Workers: the threads that a command was asked for (--threads), or as many as the system gives;
// then it says so in a line on standard error.
#pragma once

#include "src/base/threads/worker_pool.h"

namespace sluice {

class Workers : public WorkerPool {
 public:
  explicit Workers(int threads);
};

}  // namespace sluice

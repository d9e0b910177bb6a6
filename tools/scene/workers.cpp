#include "tools/scene/workers.h"

#include "tools/command_line/console.h"

namespace sluice {

Workers::Workers(int wanted) : WorkerPool(wanted) {
  if (threads() < wantedThreads())
    printWarning(fmt::format("{} of {} threads started, the system gives no more", threads(),
                             wantedThreads()));
}

}  // namespace sluice

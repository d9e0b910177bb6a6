// From the watches of the layers below to a user's ProgressFunction and stop token.
//
// A call that tells progress has a ProgressTeller. What is done for a volume whenever it comes up,
// as unpacking is, goes through the volume's ProgressRelay to the teller of the call that is under
// way.
#pragma once

#include <sluice/progress.h>

#include <cstdint>
#include <stop_token>

#include "src/base/mutex.h"
#include "src/base/progress_meter.h"
#include "src/base/stop_token.h"

namespace sluice {

// Of one call of the library's. Any thread; the user's function is called by one at a time. Throws
// Interrupted instead where the call was asked to stop.
class ProgressTeller {
 public:
  // Both outlive it. `progress` may be null.
  ProgressTeller(const ProgressFunction& progress, const std::stop_token& stop)
      : progress_(progress), on_stop_(stop, Request{&source_}) {}

  void tell(Progress::Stage stage, uint64_t done, uint64_t total);
  // tell() of this stage. The teller outlives it.
  ProgressWatch watch(Progress::Stage stage);
  // As the layers below ask it.
  StopToken stop() const { return source_.token(); }

 private:
  struct Request {
    StopSource* source;
    void operator()() const { source->requestStop(); }
  };

  const ProgressFunction& progress_;
  StopSource source_;
  std::stop_callback<Request> on_stop_;
  Mutex mutex_;  // held while the user is told
};

class ProgressRelay {
 public:
  // To the last of the calls that are under way, to nobody where there is none.
  void tell(Progress::Stage stage, uint64_t done, uint64_t total);

  // For the time of a call.
  class Call {
   public:
    Call(ProgressRelay& relay, ProgressTeller& teller);
    ~Call();
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    ProgressRelay& relay_;
    ProgressTeller& teller_;
  };

 private:
  Mutex mutex_;  // held while a teller is told: it is there until then
  ProgressTeller* teller_ SLUICE_GUARDED_BY(mutex_) = nullptr;
};

}  // namespace sluice

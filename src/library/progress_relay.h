// Connects the watches of the layers below to a user's ProgressFunction and stop token.
//
// A call that tells progress has a ProgressTeller. Work that a volume does whenever it comes up,
// such as unpacking, goes through the volume's ProgressRelay to the teller of the call that is
// under way.
#pragma once

#include <sluice/progress.h>

#include <cstdint>
#include <stop_token>

#include "src/base/threads/mutex.h"
#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

// Reports the progress of one call of the library. Any thread may call; the user's function is
// called by one thread at a time. Throws Interrupted instead if the call was asked to stop.
class ProgressTeller {
 public:
  // Both arguments must outlive it. `progress` may be null.
  ProgressTeller(const ProgressFunction& progress, const std::stop_token& stop)
      : progress_(progress), on_stop_(stop, Request{&source_}) {}

  // `done` of `total` in units of the stage's own.
  void tell(Progress::Stage stage, uint64_t done, uint64_t total);
  // tell() of this stage. The teller outlives it.
  ProgressWatch watch(Progress::Stage stage);
  // The stop token for the layers below.
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
  // To the last of the calls that are under way; to nobody if there is none.
  void tell(Progress::Stage stage, uint64_t done, uint64_t total);

  // Relays progress for the time of a call.
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

// A communicator of MPI's, as a library that is opened at run time. See mpi_module.h.
#include "src/parallel/mpi_module.h"

#include <dlfcn.h>
#include <mpi.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <string>

#include "src/base/error.h"

namespace sluice {
namespace {

// MPI counts in int.
constexpr size_t kMostBytesAtOnce = size_t{1} << 30;

void check(int result, const char* what) {
  if (result == MPI_SUCCESS) return;
  std::string text(MPI_MAX_ERROR_STRING, '\0');
  int length = 0;
  MPI_Error_string(result, text.data(), &length);
  text.resize(static_cast<size_t>(length));
  fail("MPI: {}: {}", what, text);
}

class MpiRanks : public Communicator {
 public:
  MpiRanks() {
    int is_begun = 0;
    check(MPI_Initialized(&is_begun), "cannot begin");
    int level = MPI_THREAD_SINGLE;
    if (is_begun == 0)
      check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level), "cannot begin");
    check(MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN), "cannot begin");
    check(MPI_Comm_rank(MPI_COMM_WORLD, &rank_), "cannot begin");
    check(MPI_Comm_size(MPI_COMM_WORLD, &ranks_), "cannot begin");
  }

  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }

  std::vector<uint64_t> gatherAll(std::span<const uint64_t> mine, const StopToken& stop) override {
    std::vector<uint64_t> all(mine.size() * static_cast<size_t>(ranks_));
    std::vector<MPI_Request> requests(1);
    const int count = static_cast<int>(mine.size());
    check(MPI_Iallgather(mine.data(), count, MPI_UINT64_T, all.data(), count, MPI_UINT64_T,
                         MPI_COMM_WORLD, requests.data()),
          "ranks cannot meet");
    wait(requests, stop);
    return all;
  }

  void exchange(const std::vector<Message>& to, std::vector<Message>& from,
                const StopToken& stop) override {
    std::vector<MPI_Request> requests;
    const auto me = static_cast<size_t>(rank_);
    const auto each = [&](size_t bytes, auto&& begin) {
      for (size_t at = 0; at < bytes; at += kMostBytesAtOnce) {
        requests.emplace_back();
        check(begin(at, static_cast<int>(std::min(kMostBytesAtOnce, bytes - at))),
              "a message does not go");
      }
    };
    for (int r = 0; r < ranks_; ++r) {
      const auto other = static_cast<size_t>(r);
      if (other == me) continue;
      each(from[other].size(), [&](size_t at, int bytes) {
        return MPI_Irecv(from[other].data() + at, bytes, MPI_BYTE, r, 0, MPI_COMM_WORLD,
                         &requests.back());
      });
    }
    for (int r = 0; r < ranks_; ++r) {
      const auto other = static_cast<size_t>(r);
      if (other == me) continue;
      each(to[other].size(), [&](size_t at, int bytes) {
        return MPI_Isend(to[other].data() + at, bytes, MPI_BYTE, r, 0, MPI_COMM_WORLD,
                         &requests.back());
      });
    }
    from[me] = to[me];
    wait(requests, stop);
  }

  void finish() override { check(MPI_Finalize(), "cannot end"); }

 private:
  // Not MPI_Waitall(): that takes a core while others draw on it, and hears of no signal.
  static void wait(std::vector<MPI_Request>& requests, const StopToken& stop) {
    constexpr int kTurnsAtOnce = 100;
    constexpr long kFirstPauseNs = 20'000, kLongestPauseNs = 500'000;
    long pause_ns = kFirstPauseNs;
    for (int turn = 0;; ++turn) {
      int are_done = 0;
      check(MPI_Testall(static_cast<int>(requests.size()), requests.data(), &are_done,
                        MPI_STATUSES_IGNORE),
            "a rank does not answer");
      if (are_done != 0) return;
      stop.throwIfStopped();
      if (turn < kTurnsAtOnce) {
        sched_yield();
        continue;
      }
      const timespec pause{0, pause_ns};
      nanosleep(&pause, nullptr);
      pause_ns = std::min(pause_ns + pause_ns / 8, kLongestPauseNs);
    }
  }

  int rank_ = 0, ranks_ = 1;
};

}  // namespace
}  // namespace sluice

extern "C" {

__attribute__((visibility("default"))) void sluiceJoinMpi(
    std::unique_ptr<sluice::Communicator>& ranks) {
  // Open MPI's own modules look for its symbols among everybody's.
  Dl_info info{};
  if (dladdr(reinterpret_cast<void*>(&MPI_Init_thread), &info) != 0 && info.dli_fname != nullptr)
    dlopen(info.dli_fname, RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD);
  ranks = std::make_unique<sluice::MpiRanks>();
}

__attribute__((visibility("default"))) const char* sluiceMpiModuleVersion() {
  return sluice::kMpiModuleVersion;
}
}

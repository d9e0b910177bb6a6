// A communicator of MPI's, as a library that is opened at run time. See mpi_module.h.
#include "src/parallel/communication/mpi_module.h"

#include <dlfcn.h>
#include <mpi.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

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
  failSystem("MPI: {}: {}", what, text);
}

// Messages on their way. MPI reads and writes these buffers until every request is complete.
struct Transfer {
  std::vector<uint64_t> numbers_to, numbers_from;
  std::vector<Message> to, from;
  // Receives are apart from sends and collective calls, which cannot be cancelled.
  std::vector<MPI_Request> receives, others;

  bool isDone() {
    int are_received = 0, are_sent = 0;
    check(MPI_Testall(static_cast<int>(receives.size()), receives.data(), &are_received,
                      MPI_STATUSES_IGNORE),
          "a rank does not answer");
    check(
        MPI_Testall(static_cast<int>(others.size()), others.data(), &are_sent, MPI_STATUSES_IGNORE),
        "a rank does not answer");
    return are_received != 0 && are_sent != 0;
  }
};
using Transfers = std::vector<std::unique_ptr<Transfer>>;

// A transfer that is given up when an exception leaves: its receives are cancelled, and its buffers
// move to `abandoned`. MPI may write into them as long as the process calls it, since a receive
// that has been matched cannot be cancelled, and neither can a collective call.
class Underway {
 public:
  explicit Underway(Transfers& abandoned) : abandoned_(abandoned) {
    abandoned_.reserve(abandoned_.size() + 1);  // the destructor must not throw
  }
  ~Underway() {
    if (transfer_->receives.empty() && transfer_->others.empty()) return;
    for (MPI_Request& receive : transfer_->receives)
      if (receive != MPI_REQUEST_NULL) MPI_Cancel(&receive);
    abandoned_.push_back(std::move(transfer_));
  }
  Underway(const Underway&) = delete;
  Underway& operator=(const Underway&) = delete;

  Transfer* operator->() { return transfer_.get(); }

  // MPI_Waitall() is not used: it takes a core while others draw on it, and hears of no signal.
  void wait(const StopToken& stop) {
    constexpr int kTurnsAtOnce = 100;
    constexpr long kFirstPauseNs = 20'000, kLongestPauseNs = 500'000;
    long pause_ns = kFirstPauseNs;
    for (int turn = 0; !transfer_->isDone(); ++turn) {
      stop.throwIfStopped();
      if (turn < kTurnsAtOnce) {
        sched_yield();
        continue;
      }
      const timespec pause{0, pause_ns};
      nanosleep(&pause, nullptr);
      pause_ns = std::min(pause_ns + pause_ns / 8, kLongestPauseNs);
    }
    transfer_->receives.clear();
    transfer_->others.clear();
  }

 private:
  Transfers& abandoned_;
  std::unique_ptr<Transfer> transfer_ = std::make_unique<Transfer>();
};

class MpiRanks : public Communicator {
 public:
  // The ranks are all processes. Begins MPI.
  MpiRanks() {
    int is_begun = 0;
    check(MPI_Initialized(&is_begun), "cannot begin");
    int level = MPI_THREAD_SINGLE;
    if (is_begun == 0)
      // Only the thread that owns the ranks calls MPI (communicator.h).
      check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level), "cannot begin");
    findPlace();
  }
  // The ranks are those of a program's communicator.
  explicit MpiRanks(MPI_Comm of_program) : is_shared_(true) {
    // Messages within a duplicate never meet those of the program.
    check(MPI_Comm_dup(of_program, &all_), "cannot share the communicator");
    findPlace();
  }

  // Buffers that MPI may still use stay for the rest of the process.
  ~MpiRanks() override {
    for (std::unique_ptr<Transfer>& transfer : abandoned_) static_cast<void>(transfer.release());
    int is_over = 0;
    if (is_shared_ && MPI_Finalized(&is_over) == MPI_SUCCESS && is_over == 0) MPI_Comm_free(&all_);
  }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }

  std::vector<uint64_t> gatherAll(std::span<const uint64_t> mine, const StopToken& stop) override {
    Underway transfer(abandoned_);
    transfer->numbers_to.assign(mine.begin(), mine.end());
    transfer->numbers_from.resize(mine.size() * static_cast<size_t>(ranks_));
    const int count = static_cast<int>(mine.size());
    check(MPI_Iallgather(transfer->numbers_to.data(), count, MPI_UINT64_T,
                         transfer->numbers_from.data(), count, MPI_UINT64_T, all_,
                         &transfer->others.emplace_back(MPI_REQUEST_NULL)),
          "ranks cannot meet");
    transfer.wait(stop);
    return std::move(transfer->numbers_from);
  }

  std::vector<Message> exchange(std::vector<Message> to, std::span<const uint64_t> from_bytes,
                                const StopToken& stop) override {
    Underway transfer(abandoned_);
    transfer->to = std::move(to);
    std::vector<Message>& from = transfer->from;
    const auto me = static_cast<size_t>(rank_);
    for (size_t r = 0; r < from_bytes.size(); ++r) from.emplace_back(r == me ? 0 : from_bytes[r]);
    // A message to itself does not go through MPI.
    from[me] = std::move(transfer->to[me]);
    const auto each = [&](Message& message, std::vector<MPI_Request>& requests, auto&& begin) {
      // MPI keeps the order of messages between two ranks, so that the pieces of a long one need no
      // numbers.
      for (size_t at = 0; at < message.size(); at += kMostBytesAtOnce)
        check(begin(message.data() + at,
                    static_cast<int>(std::min(kMostBytesAtOnce, message.size() - at)),
                    &requests.emplace_back(MPI_REQUEST_NULL)),
              "a message does not go");
    };
    // All receives come first: a message that arrives finds its buffer, and MPI need not keep a
    // copy.
    for (int r = 0; r < ranks_; ++r)
      if (r != rank_)
        each(from[static_cast<size_t>(r)], transfer->receives,
             [r, this](std::byte* data, int bytes, MPI_Request* request) {
               return MPI_Irecv(data, bytes, MPI_BYTE, r, 0, all_, request);
             });
    for (int r = 0; r < ranks_; ++r)
      if (r != rank_)
        each(transfer->to[static_cast<size_t>(r)], transfer->others,
             [r, this](std::byte* data, int bytes, MPI_Request* request) {
               return MPI_Isend(data, bytes, MPI_BYTE, r, 0, all_, request);
             });
    transfer.wait(stop);
    return std::move(from);
  }

  void finish() override {
    if (!is_shared_) check(MPI_Finalize(), "cannot end");
  }

 private:
  void findPlace() {
    // MPI ends the process at an error unless it is told to return it.
    check(MPI_Comm_set_errhandler(all_, MPI_ERRORS_RETURN), "cannot begin");
    check(MPI_Comm_rank(all_, &rank_), "cannot begin");
    check(MPI_Comm_size(all_, &ranks_), "cannot begin");
  }

  MPI_Comm all_ = MPI_COMM_WORLD;
  const bool is_shared_ = false;  // the program's, which ends MPI itself
  Transfers abandoned_;
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

__attribute__((visibility("default"))) void sluiceShareMpi(
    int fortran_communicator, std::unique_ptr<sluice::Communicator>& ranks) {
  const MPI_Comm of_program = MPI_Comm_f2c(fortran_communicator);
  if (of_program == MPI_COMM_NULL) sluice::fail("MPI: expected a communicator, found none");
  ranks = std::make_unique<sluice::MpiRanks>(of_program);
}

__attribute__((visibility("default"))) const char* sluiceMpiModuleVersion() {
  return sluice::kMpiModuleVersion;
}
}

#include "src/parallel/communication/in_process.h"

#include <atomic>
#include <chrono>

#include "src/base/error.h"
#include "src/base/threads/mutex.h"
#include "src/base/threads/threads.h"

namespace sluice {
namespace {

// The place where all ranks put data for each other.
struct Meeting {
  explicit Meeting(int count)
      : ranks(count), numbers(static_cast<size_t>(count)), messages(static_cast<size_t>(count)) {}

  // Waits until all ranks are here.
  void wait(const StopToken& stop) {
    MutexLock lock(mutex);
    const int64_t round = rounds;
    if (++here == ranks) {
      here = 0;
      ++rounds;
      all_here.notifyAll();
      return;
    }
    // A stop wakes nobody: waiting threads look for it ten times a second.
    while (rounds == round) {
      all_here.waitUntil(lock, std::chrono::steady_clock::now() + std::chrono::milliseconds(100));
      stop.throwIfStopped();
    }
  }

  const int ranks;
  // Each rank writes its own; the others read it after a wait().
  std::vector<std::vector<uint64_t>> numbers;
  std::vector<std::shared_ptr<std::vector<Message>>> messages;
  Mutex mutex;
  Condition all_here;
  int here SLUICE_GUARDED_BY(mutex) = 0;
  int64_t rounds SLUICE_GUARDED_BY(mutex) = 0;
};

class ThreadRank : public Communicator {
 public:
  ThreadRank(std::shared_ptr<Meeting> meeting, int rank)
      : meeting_(std::move(meeting)), rank_(rank) {}

  int rank() const override { return rank_; }
  int ranks() const override { return meeting_->ranks; }

  std::vector<uint64_t> gatherAll(std::span<const uint64_t> mine, const StopToken& stop) override {
    meeting_->numbers[static_cast<size_t>(rank_)].assign(mine.begin(), mine.end());
    meeting_->wait(stop);
    std::vector<uint64_t> all;
    for (const auto& numbers : meeting_->numbers) {
      SLUICE_CHECK_EQ(numbers.size(), mine.size());
      all.insert(all.end(), numbers.begin(), numbers.end());
    }
    // No rank may write its next numbers before all have read these.
    meeting_->wait(stop);
    return all;
  }

  std::vector<Message> exchange(std::vector<Message> to, std::span<const uint64_t> from_bytes,
                                const StopToken& stop) override {
    const auto me = static_cast<size_t>(rank_);
    meeting_->messages[me] = std::make_shared<std::vector<Message>>(std::move(to));
    meeting_->wait(stop);
    std::vector<Message> from(from_bytes.size());
    for (size_t r = 0; r < from.size(); ++r) {
      // Each message has one reader.
      from[r] = std::move((*meeting_->messages[r])[me]);
      SLUICE_CHECK_EQ(from[r].size(), from_bytes[r]);
    }
    // No rank may replace its messages before all have taken theirs.
    meeting_->wait(stop);
    return from;
  }

 private:
  const std::shared_ptr<Meeting> meeting_;
  const int rank_;
};

// The reason why the body failed; empty if it did not.
std::string endOf(Team& team, const std::function<void(Team&)>& body) {
  std::string reason;
  try {
    body(team);
    return "";
  } catch (const RankFailed& failed) {
    return failed.what();
  } catch (const Interrupted& interrupted) {
    return interrupted.what();
  } catch (const std::exception& error) {
    reason = error.what();
  }
  try {
    return team.fail(reason).what();
  } catch (const Interrupted&) {
    // The ranks have been told to stop, so that the others' reasons do not come any more.
    return reason;
  }
}

}  // namespace

std::vector<std::unique_ptr<Communicator>> inProcessRanks(int ranks) {
  const auto meeting = std::make_shared<Meeting>(ranks);
  std::vector<std::unique_ptr<Communicator>> all;
  all.reserve(static_cast<size_t>(ranks));
  for (int rank = 0; rank < ranks; ++rank)
    all.push_back(std::make_unique<ThreadRank>(meeting, rank));
  return all;
}

std::vector<std::string> runInProcess(int ranks, const std::function<void(Team& team)>& body,
                                      const StopToken& stop) {
  std::vector<std::unique_ptr<Communicator>> communicators = inProcessRanks(ranks);
  std::vector<std::string> ends(communicators.size());
  // A rank that is missing would be waited for: none begins before all are there.
  std::atomic<int> next = 0, may_begin = -1;
  auto threads = startThreads(ranks, [&] {
    may_begin.wait(-1);
    if (may_begin == 0) return;
    const auto rank = static_cast<size_t>(next++);
    Team team(std::move(communicators[rank]), stop);
    ends[rank] = endOf(team, body);
  });
  const bool all = threads.size() == communicators.size();
  may_begin = all ? 1 : 0;
  may_begin.notify_all();
  for (auto& thread : threads) thread.join();
  if (!all) failSystem("{} threads for as many ranks: the system starts {}", ranks, threads.size());
  return ends;
}

}  // namespace sluice

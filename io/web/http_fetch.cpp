#include "io/web/http_fetch.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr int kOk = 200, kPart = 206, kNotModified = 304, kUnauthorized = 401, kForbidden = 403,
              kNotFound = 404, kTimeout = 408, kGone = 410, kBeyondEnd = 416, kTooMany = 429,
              kServerFault = 500;

// Tries without a byte in between, and the time after which no other begins.
constexpr int kMostTries = 6;
constexpr double kMostSeconds = 15, kFirstWait = 0.05, kMostWait = 5;
// What is read and dropped of an object of which a part was wanted.
constexpr uint64_t kMostSkippedBytes = 1 << 20;
// A try that brings fewer counts as one without a byte: a server that trickles, or that falls
// silent in each answer, would be waited for without end.
constexpr uint64_t kLeastTryBytes = 1 << 10, kLeastSilentTryBytes = 4 << 20;

bool mayPass(int status) {
  return status == kTimeout || status == kTooMany || status >= kServerFault;
}

void waitFor(double seconds, const StopToken& stop) {
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(Seconds(seconds));
  while (Clock::now() < end) {
    stop.throwIfStopped();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace

HttpFetch::HttpFetch(HttpClient& client, const std::string& name, const std::string& url,
                     const PieceBytes& wanted, const ChunkStore::Room& room,
                     const std::optional<std::string>& known_stamp, const std::string& cached_stamp)
    : client_(client),
      name_(name),
      url_(url),
      wanted_(wanted),
      room_(room),
      known_stamp_(known_stamp),
      cached_stamp_(cached_stamp) {}

std::string HttpFetch::range() const {
  if (has_room_) {
    if (got_ == 0 && wanted_.from == PieceBytes::From::kAll) return "";
    // A further try asks for what is still missing.
    return fmt::format("{}-{}", next(), first_ + out_.size() - 1);
  }
  switch (wanted_.from) {
    case PieceBytes::From::kAll:
      return "";
    case PieceBytes::From::kStart:
      return fmt::format("{}-{}", wanted_.offset, wanted_.offset + wanted_.bytes - 1);
    case PieceBytes::From::kEnd:
      return fmt::format("-{}", wanted_.bytes);
  }
  return "";
}

// Servers answer by 416 if a part begins at the end of an object, as each part of an empty one
// does.
bool HttpFetch::isAtEnd(const HttpHead& head) const {
  if (head.status != kBeyondEnd || !head.whole) return false;
  return wanted_.from == PieceBytes::From::kStart ? wanted_.offset >= *head.whole
                                                  : *head.whole == 0 && !range().empty();
}

bool HttpFetch::takeHead(const HttpHead& head) {
  head_ = head;
  try {
    if (!has_room_ && isAtEnd(head)) {
      takeRoom(*head.whole, head.stamp);
      if (!out_.empty())
        fail("{}: expected {} bytes more than its {}", name_, out_.size(), *head.whole);
      return true;
    }
    if (head.status != kOk && head.status != kPart) return true;
    // Ranges of an encoded answer count its encoded bytes.
    if (head.is_encoded)
      failSystem(
          "{}: expected the object as it is, found a Content-Encoding; the server must not "
          "compress it",
          name_);
    const std::optional<uint64_t> whole = head.status == kPart ? head.whole : head.length;
    if (!whole || (head.status == kPart && !head.first_byte))
      fail(
          "{}: expected an answer that tells the object's size, found none; the server must send "
          "Content-Length, or Content-Range with the size for a part",
          name_);
    if (!has_room_) {
      takeRoom(*whole, head.stamp);
      // Bytes of two states of an object must not be mixed.
    } else if (*whole != whole_ || head.stamp != stamp_) {
      fail("{}: changed while it was read; open it again", name_);
    } else if (head.status == kOk && first_ == 0 && got_ > kMostSkippedBytes) {
      got_ = 0;  // the rest was asked for, and all comes again
    }
    const uint64_t from = head.status == kPart ? *head.first_byte : 0;
    if (out_.empty()) return true;
    if (from > next() || next() - from > kMostSkippedBytes || first_ + out_.size() > whole_)
      failSystem(
          "{}: expected its bytes from {} to {}, found an answer with those from {} on, of {}; the "
          "server must be able to send parts of objects (sluice fetch copies a file from any "
          "server)",
          name_, next(), first_ + out_.size(), from, whole_);
    skips_ = next() - from;
  } catch (...) {
    error_ = std::current_exception();
    return false;
  }
  return true;
}

void HttpFetch::takeRoom(uint64_t whole, const std::string& stamp) {
  const bool comes_in_parts = head_.status != kOk || wanted_.from == PieceBytes::From::kAll;
  out_ = room_({whole, known_stamp_.value_or(stamp) != stamp, comes_in_parts});
  whole_ = whole;
  stamp_ = stamp;
  first_ = wanted_.from == PieceBytes::From::kEnd ? whole_ - std::min<uint64_t>(whole_, out_.size())
                                                  : wanted_.offset;
  has_room_ = true;
}

bool HttpFetch::takeBody(std::span<const std::byte> bytes) {
  if (!has_room_ || (head_.status != kOk && head_.status != kPart)) return true;
  const uint64_t skipped = std::min<uint64_t>(skips_, bytes.size());
  skips_ -= skipped;
  bytes = bytes.subspan(skipped);
  const uint64_t taken = std::min<uint64_t>(bytes.size(), out_.size() - got_);
  if (taken > 0) std::memcpy(out_.data() + got_, bytes.data(), taken);
  got_ += taken;
  // The rest of an object that came whole is dropped with its connection if it is long.
  return !isComplete() || head_.status == kPart || whole_ <= kMostSkippedBytes;
}

void HttpFetch::refuse(const HttpHead& head) const {
  if (head.status == kUnauthorized || head.status == kForbidden)
    throw HttpForbidden(fmt::format("{}: the server forbids it (status {})", name_, head.status));
  if (head.status == kBeyondEnd && !range().empty())
    fail("{}: expected bytes {}, found that it ends before", name_, range());
  fail("{}: the server answered with status {}; check the address", name_, head.status);
}

std::string HttpFetch::whyIncomplete(const HttpEnd& end, bool is_answer) const {
  if (!is_answer && head_.status != 0 && end.fault.empty())
    return fmt::format("the server answered with status {}", head_.status);
  std::string fault = end.fault.empty() ? "the answer is too short" : end.fault;
  if (!has_room_) return fault;
  return fmt::format("{} of {} bytes came: {}", got_, out_.size(), fault);
}

HttpFetch::Outcome HttpFetch::run(const StopToken& stop, bool tries_again) {
  Clock::time_point since = Clock::now();
  for (int tries = 1;; ++tries) {
    const uint64_t before = got_;
    head_ = {};
    // A stamp asks whether the object has changed; with bytes in hand, that is no longer the
    // question.
    const HttpEnd end = client_.get({url_, range(), has_room_ ? "" : cached_stamp_,
                                     [this](const HttpHead& h) { return takeHead(h); },
                                     [this](auto bytes) { return takeBody(bytes); }},
                                    stop);
    if (error_) std::rethrow_exception(error_);
    if (has_room_ && out_.empty() && isAtEnd(head_)) return Outcome::kRead;
    const bool is_answer = head_.status == kOk || head_.status == kPart;
    if (is_answer && isComplete()) return Outcome::kRead;
    if (head_.status == kNotModified && !has_room_) return Outcome::kUnchanged;
    if (head_.status == kNotFound || head_.status == kGone) {
      if (has_room_) failSystem("{}: went away while it was read; open it again", name_);
      return Outcome::kMissing;
    }
    if (head_.status != 0 && !is_answer && !mayPass(head_.status)) refuse(head_);
    // A try that brings bytes begins the count of tries and the time anew.
    const uint64_t came = got_ > before ? got_ - before : 0;
    if (came >= (end.is_silent ? kLeastSilentTryBytes : kLeastTryBytes)) {
      since = Clock::now();
      tries = 0;
    }
    const double spent = Seconds(Clock::now() - since).count();
    const bool may_pass = end.fault.empty() || end.may_pass;
    if (!may_pass || !tries_again || tries >= kMostTries || spent > kMostSeconds) {
      const std::string why = whyIncomplete(end, is_answer);
      if (!may_pass) failSystem("{}: {}", name_, why);
      failSystem("{}: {}; tried {} times in {:.0f} s; check the address, or try again later", name_,
                 why, std::max(tries, 1), spent);
    }
    // Doubled from try to try, so that a busy server is not asked more and more often.
    const double wait = kFirstWait * static_cast<double>(1 << std::clamp(tries - 1, 0, 5));
    waitFor(std::clamp(head_.retry_after_s, std::min(wait, kMostWait), kMostWait), stop);
  }
}

bool streamObject(HttpClient& client, const std::string& name, const std::string& url,
                  const KnownPiece& known, const ChunkStore::Take& take, const StopToken& stop) {
  HttpHead head;
  bool is_as_known = false;
  uint64_t got = 0;
  std::exception_ptr error;
  const auto on_head = [&](const HttpHead& of_answer) {
    head = of_answer;
    is_as_known = (known.stamp.empty() || head.stamp == known.stamp) &&
                  head.length.value_or(known.bytes) == known.bytes && !head.is_encoded;
    return head.status == kOk && is_as_known;
  };
  const auto on_body = [&](std::span<const std::byte> bytes) {
    if (bytes.size() > known.bytes - got) {
      is_as_known = false;
      return false;
    }
    try {
      take(bytes);
    } catch (...) {
      error = std::current_exception();
      return false;
    }
    got += bytes.size();
    return true;
  };
  const HttpEnd end = client.get({url, "", "", on_head, on_body}, stop);
  if (error) std::rethrow_exception(error);
  if (head.status == kNotFound || head.status == kGone) return false;
  if (head.status != kOk)
    failSystem("{}: {}; try again later", name,
               head.status == 0 ? end.fault
                                : fmt::format("the server answered with status {}", head.status));
  if (!is_as_known) fail("{}: changed while it was read; try again", name);
  if (got < known.bytes)
    failSystem(
        "{}: {} of {} bytes came{}; the server does not send parts of objects, so that the same "
        "command begins anew",
        name, got, known.bytes, end.fault.empty() ? "" : ": " + end.fault);
  return true;
}

}  // namespace sluice

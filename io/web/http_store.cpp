#include "io/web/http_store.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <exception>
#include <utility>

#include "io/web/http_fetch.h"
#include "src/base/error.h"
#include "src/base/threads/deadline.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {
namespace {

constexpr uint64_t kMostKeptBytes = 16 << 20;
// A change of objects beyond these is found by their own checksums alone.
constexpr size_t kMostStamps = 1 << 16;
constexpr std::chrono::seconds kMostExpecting{3};

// The name of a piece in the cache. It says neither who asked nor with what query.
std::string cacheName(const std::string& object, const PieceBytes& wanted) {
  return fmt::format("{} {} {} {}", object, static_cast<int>(wanted.from), wanted.offset,
                     wanted.bytes);
}

}  // namespace

HttpStore::HttpStore(Address address, HttpCredentials credentials, const WebOptions& options,
                     StopToken stop)
    : address_(std::move(address)),
      stop_(std::move(stop)),
      client_(std::move(credentials), options.certificates),
      warn_(options.warn) {
  const WebCache& cache = options.cache;
  if (cache.budget_bytes > 0) cache_.emplace(cache.folder, cache.budget_bytes);
}

std::string HttpStore::wholeKey(const std::string& key) const {
  return key;
}

std::string HttpStore::urlOf(const std::string& key) const {
  // Characters that a path may have as they are (RFC 3986, 3.3), and the percent sign of those that
  // are escaped already.
  constexpr std::string_view kPlain = "-._~!$&'()*+,;=:@/%";
  std::string url = address_.server + "/";
  for (const char c : key) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (is_letter || (c >= '0' && c <= '9') || kPlain.find(c) != std::string_view::npos)
      url += c;
    else
      url += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return url + address_.query;
}

bool HttpStore::has(const std::string& key) {
  {
    const MutexLock lock(mutex_);
    if (const auto found = kept_.find(key); found != kept_.end()) return found->second.is_there;
  }
  return ask(key, {true, stop_});
}

// Each is asked for once, and for a few seconds at most: has() asks again for what did not come,
// and says what is wrong.
void HttpStore::expect(const std::vector<std::string>& keys) {
  std::vector<std::string> left;
  {
    const MutexLock lock(mutex_);
    for (const std::string& key : keys)
      if (!kept_.contains(key)) left.push_back(key);
  }
  if (left.size() < 2) return;
  const Deadline enough(std::chrono::steady_clock::now() + kMostExpecting, stop_);
  WorkerPool pool(static_cast<int>(std::min<size_t>(left.size(), kMostReads)));
  pool.parallelFor(static_cast<int64_t>(left.size()), [&](int64_t i) {
    try {
      enough.token().throwIfStopped();
      ask(left[static_cast<size_t>(i)], {false, enough.token()});
    } catch (const std::exception&) {
    }
  });
}

bool HttpStore::ask(const std::string& key, const Patience& patience) {
  Kept kept;
  try {
    kept.is_there = fetch(
        key, {},
        [&](const PieceInfo& piece) {
          if (piece.bytes > kMostKeptBytes)
            fail("{}: expected metadata of at most {} bytes, found {}", nameOf(key), kMostKeptBytes,
                 piece.bytes);
          kept.bytes.resize(piece.bytes);
          return std::span(kept.bytes);
        },
        patience);
    // Buckets that do not let their objects be listed answer so for one that is not there.
  } catch (const HttpForbidden&) {
  }
  const MutexLock lock(mutex_);
  // If two threads asked, the first answer stays.
  return kept_.emplace(key, std::move(kept)).first->second.is_there;
}

bool HttpStore::read(const std::string& key, const PieceBytes& wanted, const Room& room) {
  if (wanted.from == PieceBytes::From::kAll) {
    MutexLock lock(mutex_);
    if (const auto found = kept_.find(key); found != kept_.end()) {
      const Kept& kept = found->second;
      if (!kept.is_there) return false;
      const std::span<std::byte> out = room({kept.bytes.size(), false});
      std::copy(kept.bytes.begin(), kept.bytes.end(), out.begin());
      return true;
    }
  }
  return fetch(key, wanted, room, {true, stop_});
}

bool HttpStore::stream(const std::string& key, const KnownPiece& known, const Take& take) {
  return streamObject(client_, nameOf(key), urlOf(key), known, take, stop_);
}

std::optional<std::string> HttpStore::stampKnown(const std::string& key) {
  const MutexLock lock(mutex_);
  const auto found = stamps_.find(key);
  return found == stamps_.end() ? std::nullopt : std::optional(found->second);
}

void HttpStore::learnStamp(const std::string& key, const std::string& stamp) {
  const MutexLock lock(mutex_);
  if (stamps_.size() < kMostStamps) stamps_.emplace(key, stamp);
}

void HttpStore::keepInCache(const std::string& cache_name, const HttpFetch& fetched) {
  if (!cache_ || fetched.stamp().empty()) return;
  const std::optional<std::string> fault =
      cache_->keep(cache_name, fetched.stamp(), fetched.wholeBytes(), fetched.bytes());
  if (fault && warn_ && !has_warned_.test_and_set())
    warn_(fmt::format(
        "the cache does not keep all that is read: {} (--cache-dir names another folder)", *fault));
}

bool HttpStore::fetch(const std::string& key, const PieceBytes& wanted, const Room& room,
                      const Patience& patience) {
  const std::optional<std::string> known = stampKnown(key);
  const std::string name = nameOf(key), url = urlOf(key);
  const std::string cache_name = cacheName(name, wanted);
  const std::optional<CachedPiece> cached = cache_ ? cache_->find(cache_name) : std::nullopt;
  // The room is asked for once, also if what the cache has turns out to be damaged.
  std::optional<std::span<std::byte>> given;
  const Room once = [&](const PieceInfo& piece) {
    if (!given) given = room(piece);
    return *given;
  };
  std::string cached_stamp = cached ? cached->stamp() : "";
  // A piece that this process has seen once is not asked for again.
  const bool is_checked = cached && known == cached_stamp;
  for (;;) {
    HttpFetch fetch(client_, name, url, wanted, once, known, cached_stamp);
    const HttpFetch::Outcome outcome = is_checked && !given
                                           ? HttpFetch::Outcome::kUnchanged
                                           : fetch.run(patience.stop, patience.tries_again);
    if (outcome == HttpFetch::Outcome::kMissing) return false;
    if (outcome == HttpFetch::Outcome::kRead) {
      learnStamp(key, fetch.stamp());
      keepInCache(cache_name, fetch);
      return true;
    }
    learnStamp(key, cached_stamp);
    if (cached->read(once({cached->wholeBytes(), known.value_or(cached_stamp) != cached_stamp})))
      return true;
    cache_->remove(cache_name);
    cached_stamp.clear();
  }
}

std::optional<uint64_t> HttpStore::keptCopy(const std::string& key, const PieceBytes& wanted,
                                            std::span<std::byte> out) {
  if (!cache_) return std::nullopt;
  const std::optional<CachedPiece> cached = cache_->find(cacheName(nameOf(key), wanted));
  if (!cached || (!out.empty() && !cached->read(out))) return std::nullopt;
  return cached->bytes();
}

std::string HttpStore::stampOf(const std::string& key) {
  const MutexLock lock(mutex_);
  const auto known = stamps_.find(key);
  return known == stamps_.end() ? "" : known->second;
}

void HttpStore::list(const std::string& folder, const std::function<void(const Entry&)>&) {
  failRequest("{}: a web server does not list its objects", nameOf(folder));
}

}  // namespace sluice

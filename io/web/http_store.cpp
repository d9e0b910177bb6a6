#include "io/web/http_store.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <exception>
#include <thread>
#include <utility>

#include "io/web/http_fetch.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMostKeptBytes = 16 << 20;
// A change of objects beyond these is found by their own checksums alone.
constexpr size_t kMostStamps = 1 << 16;

}  // namespace

HttpStore::HttpStore(Address address, HttpCredentials credentials, StopToken stop)
    : address_(std::move(address)), stop_(std::move(stop)), client_(std::move(credentials)) {}

std::string HttpStore::wholeKey(const std::string& key) const {
  return key;
}

std::string HttpStore::urlOf(const std::string& key) const {
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
  Kept kept;
  try {
    kept.is_there = fetch(key, {}, [&](const PieceInfo& piece) {
      if (piece.bytes > kMostKeptBytes)
        fail("{}: expected metadata of at most {} bytes, found {}", nameOf(key), kMostKeptBytes,
             piece.bytes);
      kept.bytes.resize(piece.bytes);
      return std::span(kept.bytes);
    });
  } catch (const HttpForbidden&) {
  }
  const MutexLock lock(mutex_);
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
  return fetch(key, wanted, room);
}

bool HttpStore::fetch(const std::string& key, const PieceBytes& wanted, const Room& room) {
  std::optional<std::string> known;
  {
    const MutexLock lock(mutex_);
    if (const auto found = stamps_.find(key); found != stamps_.end()) known = found->second;
  }
  const std::string name = nameOf(key), url = urlOf(key);
  HttpFetch fetch(client_, name, url, wanted, room, known);
  if (!fetch.run(stop_)) return false;
  const MutexLock lock(mutex_);
  if (stamps_.size() < kMostStamps) stamps_.emplace(key, fetch.stamp());
  return true;
}

std::string HttpStore::stampOf(const std::string& key) {
  const MutexLock lock(mutex_);
  const auto known = stamps_.find(key);
  return known == stamps_.end() ? "" : known->second;
}

void HttpStore::list(const std::string& folder, const std::function<void(const Entry&)>&) {
  fail("{}: a web server does not list its objects", nameOf(folder));
}

}  // namespace sluice

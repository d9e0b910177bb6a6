// The objects of a web server as a ChunkStore.
//
// What a server drops, delays or refuses for a while is asked for again, from the byte where it
// stopped; an object that changes meanwhile is an Error. The metadata that has() asks for are kept,
// so that nothing is asked for twice.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "io/stores/chunk_store.h"
#include "io/web/address.h"
#include "io/web/http_client.h"
#include "io/web/piece_cache.h"

namespace sluice {

class HttpFetch;

class HttpStore final : public ChunkStore {
 public:
  // Throws Error: the cache's folder cannot be written.
  HttpStore(Address address, HttpCredentials credentials, const WebOptions& options,
            StopToken stop);

  std::string wholeKey(const std::string& key) const override;
  std::string nameOf(const std::string& key) const override { return address_.server + "/" + key; }
  // An object that the server forbids is not there for has(): buckets answer so for any that is
  // not.
  bool has(const std::string& key) override;
  void expect(const std::vector<std::string>& keys) override;
  bool read(const std::string& key, const PieceBytes& wanted, const Room& room) override;
  bool stream(const std::string& key, const KnownPiece& known, const Take& take) override;
  std::optional<uint64_t> keptCopy(const std::string& key, const PieceBytes& wanted,
                                   std::span<std::byte> out) override;
  std::string stampOf(const std::string& key) override;
  bool canList() const override { return false; }
  int distantReads() const override { return kMostReads; }
  void list(const std::string& folder,
            const std::function<void(const Entry& entry)>& take) override;

 private:
  static constexpr int kMostReads = 16;  // at a time
  struct Kept {
    bool is_there = false;
    std::vector<std::byte> bytes;
  };
  // How often to ask a server that drops or refuses what may come later.
  struct Patience {
    bool tries_again = true;
    StopToken stop;
  };
  // has() of an object that is not kept yet. Throws Error, Interrupted.
  bool ask(const std::string& key, const Patience& patience);
  bool fetch(const std::string& key, const PieceBytes& wanted, const Room& room,
             const Patience& patience);
  std::optional<std::string> stampKnown(const std::string& key);
  void learnStamp(const std::string& key, const std::string& stamp);
  // Keeps what was read in the cache, if there is one and the server tells when it changes.
  void keepInCache(const std::string& cache_name, const HttpFetch& fetched);
  std::string urlOf(const std::string& key) const;

  const Address address_;
  const StopToken stop_;
  HttpClient client_;
  std::optional<PieceCache> cache_;
  const std::function<void(const std::string& line)> warn_;
  std::atomic_flag has_warned_;
  Mutex mutex_;
  std::map<std::string, Kept> kept_ SLUICE_GUARDED_BY(mutex_);  // asked for by has()
  std::unordered_map<std::string, std::string> stamps_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice

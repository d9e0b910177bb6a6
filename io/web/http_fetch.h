// HttpFetch: one object, or a part of it, in as many requests as it takes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <string>

#include "io/stores/chunk_store.h"
#include "io/web/http_client.h"
#include "src/base/error.h"

namespace sluice {

// The server knows who asks, and refuses (401, 403).
class HttpForbidden : public Error {
  using Error::Error;
};

class HttpFetch {
 public:
  // `name`: for messages; `known_stamp`: the object's when it was read before; `cached_stamp`: of
  // the bytes that a cache has, or empty. All must outlive it.
  HttpFetch(HttpClient& client, const std::string& name, const std::string& url,
            const PieceBytes& wanted, const ChunkStore::Room& room,
            const std::optional<std::string>& known_stamp, const std::string& cached_stamp);

  enum class Outcome { kMissing, kRead, kUnchanged };
  // kMissing: there is no object; kUnchanged: it has the cached stamp still, and `room` was not
  // called. Throws Error: after some tries within half a minute without a byte, or the first if it
  // does not try again; Interrupted.
  Outcome run(const StopToken& stop, bool tries_again = true);
  // After kRead: of the object, as the server tells; may be empty.
  const std::string& stamp() const { return stamp_; }
  uint64_t wholeBytes() const { return whole_; }
  std::span<const std::byte> bytes() const { return out_; }

 private:
  bool takeHead(const HttpHead& head);
  // The answer says that the wanted part begins where the object ends, and nothing is left to read.
  bool isAtEnd(const HttpHead& head) const;
  // Asks for room, once the size of the object is known.
  void takeRoom(uint64_t whole, const std::string& stamp);
  bool takeBody(std::span<const std::byte> bytes);
  // The first byte wanted and not there yet, of the object.
  uint64_t next() const { return first_ + got_; }
  // Of the next request; empty: all.
  std::string range() const;
  void refuse(const HttpHead& head) const;
  // The reason that not all bytes came, as the rest of a line that begins with the name.
  std::string whyIncomplete(const HttpEnd& end, bool is_answer) const;
  // All bytes are there.
  bool isComplete() const { return has_room_ && got_ == out_.size(); }

  HttpClient& client_;
  const std::string& name_;
  const std::string& url_;
  const PieceBytes& wanted_;
  const ChunkStore::Room& room_;
  const std::optional<std::string>& known_stamp_;
  const std::string& cached_stamp_;
  HttpHead head_;                   // of the request that goes on
  uint64_t whole_ = 0, first_ = 0;  // known with room
  bool has_room_ = false;
  std::span<std::byte> out_;
  uint64_t got_ = 0, skips_ = 0;  // bytes: in `out_`; of the body before them
  std::string stamp_;
  std::exception_ptr error_;
};

// ChunkStore::stream() of an object, in one request that is not tried again.
bool streamObject(HttpClient& client, const std::string& name, const std::string& url,
                  const KnownPiece& known, const ChunkStore::Take& take, const StopToken& stop);

}  // namespace sluice

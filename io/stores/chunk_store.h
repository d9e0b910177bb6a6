// ChunkStore: pieces of bytes under names: the files of a folder, the objects of a web server. The
// readers of chunked formats read out of one without knowing which it is.
//
// A key is a piece's path, with '/' between its parts. Every member may be called from any thread
// at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sluice {

// What a store tells of a piece before it hands out bytes.
struct PieceInfo {
  uint64_t bytes = 0;          // of the whole piece
  bool has_changed = false;    // since the store was opened
  bool comes_in_parts = true;  // false: a part was asked for, and the whole piece comes
};

// A piece as it was when it was last asked for.
struct KnownPiece {
  std::string stamp;  // empty: not known
  uint64_t bytes = 0;
};

// The bytes of a piece that are wanted.
struct PieceBytes {
  enum class From { kAll, kStart, kEnd };
  From from = From::kAll;
  uint64_t offset = 0;  // kStart: of the first byte
  uint64_t bytes = 0;   // kStart: from there on; kEnd: the last ones
};

class ChunkStore {
 public:
  virtual ~ChunkStore() = default;

  // A key with all folders that it lies in, without "." and "..".
  virtual std::string wholeKey(const std::string& key) const = 0;
  // How messages and reports name a piece.
  virtual std::string nameOf(const std::string& key) const = 0;

  // Whether there is such a piece or folder. A store that cannot tell a folder from nothing says
  // no. Throws Error: it cannot be found out.
  virtual bool has(const std::string& key) = 0;

  // Says that has() will be asked for these pieces. A store whose answers take their time asks for
  // all of them at once. Never fails.
  virtual void expect(const std::vector<std::string>& /*keys*/) {}

  // Memory for the wanted bytes, as long as they are; or throws.
  using Room = std::function<std::span<std::byte>(const PieceInfo& piece)>;
  // Fills the memory that `room` returns, which is called once. Returns false, and does not call
  // it, if there is no such piece. Throws Error, naming the piece: it cannot be read, or is shorter
  // than that; and what `room` throws.
  virtual bool read(const std::string& key, const PieceBytes& wanted, const Room& room) = 0;

  // Hands out all bytes of a piece in their order, a few at a time, where it does not come in
  // parts. Returns false if there is no such piece. Throws Error, naming the piece: not all of it
  // came, or it is not as it is known; and what `take` throws.
  using Take = std::function<void(std::span<const std::byte> bytes)>;
  virtual bool stream(const std::string& key, const KnownPiece& known, const Take& take);

  // The copy of a piece that this machine keeps, if read() asked for just these bytes before: its
  // length, and with `out` its bytes, which must have that length. nullopt: there is none, it is
  // damaged, or the store keeps no copies. Whether the piece has changed since is not asked.
  virtual std::optional<uint64_t> keptCopy(const std::string& /*key*/, const PieceBytes& /*wanted*/,
                                           std::span<std::byte> /*out*/ = {}) {
    return std::nullopt;
  }

  // A text that changes when the piece or the folder does, as far as the store knows without
  // reading it; "none" if there is none. Never fails.
  virtual std::string stampOf(const std::string& key) = 0;

  // See VolumeSource::distantReads().
  virtual int distantReads() const { return 0; }

  struct Entry {
    std::string name;  // the last part of its key
    bool is_folder = false;
  };
  // Whether the contents of a folder can be asked for. Otherwise a piece is missing if it cannot be
  // read.
  virtual bool canList() const = 0;
  // Calls `take` for each of the contents of a folder, in any order; never for a folder that is not
  // there. Requires: canList(). Throws Error.
  virtual void list(const std::string& folder,
                    const std::function<void(const Entry& entry)>& take) = 0;
};

// A piece or folder in a store.
struct StorePlace {
  std::shared_ptr<ChunkStore> store;
  std::string key;

  StorePlace at(const std::string& below) const;
  // The folder around it; itself where there is none.
  StorePlace around() const;
  // The last part of its key; of the store's name if the key is empty.
  std::string lastPart() const;

  std::string name() const { return store->nameOf(key); }
  bool has(const std::string& below) const { return store->has(at(below).key); }
};

// The files that describe a folder of a store: Zarr's of either version, and N5's.
inline constexpr std::array<const char*, 5> kStoreMetadata = {"zarr.json", ".zarray", ".zgroup",
                                                              "attributes.json", ".zattrs"};
// Whether a folder has one of them.
bool isStore(const StorePlace& folder);

}  // namespace sluice

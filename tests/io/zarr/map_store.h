// MapStore: pieces in memory, by the paths that files have below a folder. It cannot be listed, as
// a web server cannot.
#pragma once

#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "io/stores/chunk_store.h"
#include "src/base/error.h"
#include "tests/io/python_volumes.h"

namespace sluice {

class MapStore final : public ChunkStore {
 public:
  explicit MapStore(const std::filesystem::path& folder) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      if (entry.is_regular_file())
        pieces[std::filesystem::relative(entry.path(), folder).string()] = readFile(entry.path());
  }

  std::string wholeKey(const std::string& key) const override { return key; }
  std::string nameOf(const std::string& key) const override { return "map:" + key; }
  bool has(const std::string& key) override { return pieces.contains(key); }
  void expect(const std::vector<std::string>& keys) override { expected = keys; }
  bool read(const std::string& key, const PieceBytes& wanted, const Room& room) override {
    {
      const std::lock_guard lock(mutex_);
      ++reads[key];
    }
    if (before_read) before_read(key);
    const auto found = pieces.find(key);
    if (found == pieces.end()) return false;
    const std::string& piece = found->second;
    const std::span<std::byte> out = room({piece.size(), has_changed});
    {
      const std::lock_guard lock(mutex_);
      parts[key].emplace_back(wanted.from, out.size());
    }
    const bool is_last = wanted.from == PieceBytes::From::kEnd;
    const size_t from = is_last ? piece.size() - out.size() : wanted.offset;
    if (from + out.size() > piece.size()) fail("{}: too short", nameOf(key));
    std::memcpy(out.data(), piece.data() + from, out.size());
    return true;
  }
  std::string stampOf(const std::string& key) override { return has(key) ? "there" : "none"; }
  bool canList() const override { return false; }
  void list(const std::string&, const std::function<void(const Entry&)>&) override { std::abort(); }

  std::map<std::string, std::string> pieces;
  std::vector<std::string> expected;  // as it was told last
  std::map<std::string, int> reads;   // how often each was asked for
  // What was read of each, in its order: from its start or its end, and how many bytes.
  std::map<std::string, std::vector<std::pair<PieceBytes::From, uint64_t>>> parts;
  bool has_changed = false;
  std::function<void(const std::string& key)> before_read;

 private:
  std::mutex mutex_;
};

}  // namespace sluice

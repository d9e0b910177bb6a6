#include "io/stores/chunk_store.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/base/values/text_parts.h"

namespace sluice {

bool ChunkStore::stream(const std::string& key, const KnownPiece& known, const Take& take) {
  std::vector<std::byte> bytes;
  const bool is_there = read(key, {}, [&](const PieceInfo& piece) {
    if (piece.bytes != known.bytes) fail("{}: changed while it was read; try again", nameOf(key));
    bytes.resize(piece.bytes);
    return std::span(bytes);
  });
  if (is_there) take(bytes);
  return is_there;
}

StorePlace StorePlace::at(const std::string& below) const {
  if (key.empty()) return {store, below};
  return {store, key.back() == '/' ? key + below : key + "/" + below};
}

StorePlace StorePlace::around() const {
  const std::string whole(withoutSlashes(store->wholeKey(key)));
  const size_t end = whole.rfind('/');
  if (end == std::string::npos) return {store, ""};
  return {store, whole.substr(0, end == 0 ? 1 : end)};
}

std::string StorePlace::lastPart() const {
  std::string whole(withoutSlashes(store->wholeKey(key)));
  if (whole.empty()) whole = withoutSlashes(store->nameOf(whole));
  return whole.substr(whole.rfind('/') + 1);
}

bool isStore(const StorePlace& folder) {
  return std::ranges::any_of(kStoreMetadata, [&](const char* name) { return folder.has(name); });
}

}  // namespace sluice

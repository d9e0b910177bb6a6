// The files of this machine as a ChunkStore: a key is a path, as the user named it.
#pragma once

#include <ctime>
#include <filesystem>

#include "io/stores/chunk_store.h"

namespace sluice {

// Files are opened for each read. One that was written after the store was made has changed.
class FolderStore final : public ChunkStore {
 public:
  FolderStore();

  std::string wholeKey(const std::string& key) const override;
  std::string nameOf(const std::string& key) const override { return key; }
  bool has(const std::string& key) override;
  bool read(const std::string& key, const PieceBytes& wanted, const Room& room) override;
  // The file's size, times and inode.
  std::string stampOf(const std::string& key) override;
  bool canList() const override { return true; }
  void list(const std::string& folder,
            const std::function<void(const Entry& entry)>& take) override;

 private:
  timespec opened_at_ = {};  // constant after construction
};

// A place in a new store of this folder. Nothing is read yet.
StorePlace folderPlace(const std::filesystem::path& folder);

}  // namespace sluice

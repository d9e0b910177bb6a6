// The files in a zip file as a ChunkStore: a key is a path in it. Stored entries are read in
// parts; deflated ones are decoded whole. The checksum of an entry is compared if all of it is
// read.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "io/files/file.h"
#include "io/stores/chunk_store.h"
#include "io/stores/zip_directory.h"

namespace sluice {

class ZipStore final : public ChunkStore {
 public:
  // Throws Error: see ZipDirectory.
  explicit ZipStore(const std::filesystem::path& path);

  std::string wholeKey(const std::string& key) const override;
  std::string nameOf(const std::string& key) const override {
    return key.empty() ? file_->path() : file_->path() + '/' + key;
  }
  bool has(const std::string& key) override;
  bool read(const std::string& key, const PieceBytes& wanted, const Room& room) override;
  // The zip file's identity: all of them change together.
  std::string stampOf(const std::string& key) override;
  bool canList() const override { return true; }
  void list(const std::string& folder,
            const std::function<void(const Entry& entry)>& take) override;

 private:
  // Decodes the entry up to the end of `out`, whose first byte is number `from` of it. Returns the
  // checksum of all that it decoded.
  uint32_t inflateInto(const ZipEntry& entry, uint64_t from, std::span<std::byte> out);

  const std::shared_ptr<File> file_;
  const ZipDirectory directory_;
  const std::string identity_;
};

// The volume in a zip file: `inside`, or if that is empty its root, or what lies in the only folder
// there.
StorePlace zipPlace(const std::filesystem::path& path, const std::string& inside);

}  // namespace sluice

// DecodedFile: the voxels of compressed (or written-out) files, decoded once into a temporary file.
//
// A single compressed stream has no way in but from its start. So the first read decodes all of it
// into a file without a name, in the folder of DecodeOptions, which is gone when the DecodedFile
// is; later reads equal those of an uncompressed file. Memory use is a fixed 1 MiB. No more is
// written than was declared, whatever the stream holds. The thread that comes first decodes, the
// others wait.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/files/byte_store.h"
#include "io/files/decoder.h"
#include "io/files/file.h"
#include "io/headers/decode_options.h"
#include "src/base/threads/mutex.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

enum class Codec { kDeflate, kText };  // gzip or zlib; numbers as text

// An encoded file of a volume, and the part of its decoded bytes that belongs to the volume.
struct EncodedFile {
  std::shared_ptr<File> file;
  uint64_t offset_bytes = 0;        // start of the stream
  uint64_t skip_bytes = 0;          // decoded bytes to leave out
  uint64_t keep_bytes = 0;          // decoded bytes that follow, up to the stream's end
  uint64_t end_bytes = UINT64_MAX;  // text: where it ends in the file, at the latest
};

class DecodedFile : public ByteStore {
 public:
  // The decoded files one after the other. `arithmetic` explains keep_bytes of one file in
  // messages. `type` is the voxel type of kText. Throws Error when the files cannot hold so much
  // (deflate makes at most 1032 bytes of one), so that a lie in a header costs nothing.
  DecodedFile(std::vector<EncodedFile> inputs, Codec codec, VoxelType type, std::string arithmetic,
              DecodeOptions options = {});
  ~DecodedFile() override;
  DecodedFile(const DecodedFile&) = delete;
  DecodedFile& operator=(const DecodedFile&) = delete;

  // The first call decodes, and tells the watch. Throws Error when a stream is damaged, too short
  // or too long, or the disk is full; a failure is remembered and thrown at every later call.
  void read(uint64_t offset, std::span<const iovec> parts) override;
  bool isOneStream() const override { return true; }
  uint64_t storedBytesRead() const override;
  std::vector<std::string> paths() const override;

 private:
  void decodeOnce();
  void decodeAll(const std::string& folder, int descriptor);
  std::unique_ptr<Decoder> open(const EncodedFile& input) const;

  const std::vector<EncodedFile> inputs_;
  const Codec codec_;
  const VoxelType type_;
  const std::string arithmetic_;
  const DecodeOptions options_;
  uint64_t total_bytes_ = 0;  // constant after construction

  std::atomic<int> descriptor_{-1};  // the temporary file; -1 until all is decoded
  Mutex mutex_;                      // held while decoding
  std::string failure_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice

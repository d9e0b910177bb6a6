#include "io/headers/decoded_file.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "io/files/inflater.h"
#include "io/headers/text_voxels.h"
#include "src/base/error.h"
#include "src/base/files/descriptor.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {

constexpr size_t kChunkBytes = 1024 * 1024;
constexpr uint64_t kMaxDeflateRatio = 1032;  // 258 bytes from two bits

// /var/tmp before /tmp: the latter is often memory.
std::string temporaryFolder(const DecodeOptions& options) {
  if (!options.folder.empty()) return options.folder;
  return access("/var/tmp", W_OK) == 0 ? "/var/tmp" : "/tmp";
}

int openUnnamed(const std::string& folder) {
  const int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor >= 0) return descriptor;
  // Some file systems (overlays, network folders) have no unnamed files.
  std::string pattern = folder + "/sluice-XXXXXX";
  const int named = mkostemp(pattern.data(), O_CLOEXEC);
  if (named < 0)
    failErrno(
        fmt::format("{}: no temporary file for decoding; set TMPDIR to a folder with room", folder),
        errno);
  // Without a name, the file goes with the process, however that ends.
  unlink(pattern.c_str());
  return named;
}

void demandRoom(const std::string& path, const std::string& folder, int descriptor,
                uint64_t bytes) {
  struct statvfs room = {};
  if (fstatvfs(descriptor, &room) != 0) return;
  const uint64_t free_bytes = static_cast<uint64_t>(room.f_bavail) * room.f_frsize;
  if (free_bytes < bytes)
    fail("{}: decoding needs {} in {}, {} are free; set TMPDIR to a folder with room", path,
         formatBytes(bytes), folder, formatBytes(free_bytes));
}

void append(const std::string& folder, int descriptor, std::span<const std::byte> bytes) {
  writeAll(descriptor, bytes,
           fmt::format("{}: the temporary file cannot be written; set TMPDIR to a folder with room",
                       folder));
}

}  // namespace

DecodedFile::DecodedFile(std::vector<EncodedFile> inputs, Codec codec, VoxelType type,
                         std::string arithmetic, DecodeOptions options)
    : inputs_(std::move(inputs)),
      codec_(codec),
      type_(type),
      arithmetic_(std::move(arithmetic)),
      options_(std::move(options)) {
  for (const EncodedFile& input : inputs_) {
    const uint64_t size = std::min(input.file->sizeBytes(), input.end_bytes);
    const uint64_t encoded = size - std::min(size, input.offset_bytes);
    // Each voxel takes at least a digit and, except the last, a separator of the text.
    // Checked before a disk is filled: a header may claim more than the data can hold.
    const uint64_t most = codec_ == Codec::kDeflate ? encoded * kMaxDeflateRatio
                                                    : (encoded + 1) / 2 * bytesPerVoxel(type_);
    if (input.keep_bytes > most || input.skip_bytes > most - input.keep_bytes)
      fail("{}: {} expected, the {} bytes of encoded data can hold {} at most", input.file->path(),
           arithmetic_, encoded, most);
    total_bytes_ += input.keep_bytes;
  }
}

DecodedFile::~DecodedFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

uint64_t DecodedFile::storedBytesRead() const {
  uint64_t sum = 0;
  for (const EncodedFile& input : inputs_) sum += input.file->storedBytesRead();
  return sum;
}

std::vector<std::string> DecodedFile::paths() const {
  std::vector<std::string> all;
  for (const EncodedFile& input : inputs_) all.push_back(input.file->path());
  return all;
}

std::unique_ptr<Decoder> DecodedFile::open(const EncodedFile& input) const {
  if (codec_ == Codec::kText)
    return std::make_unique<TextVoxels>(input.file, input.offset_bytes, type_, input.end_bytes);
  return std::make_unique<Inflater>(input.file, input.offset_bytes);
}

void DecodedFile::decodeOnce() {
  const MutexLock lock(mutex_);
  if (descriptor_ >= 0) return;
  // Several threads ask: the first one decodes, and the others get its result.
  if (!failure_.empty()) throw Error(failure_);
  try {
    const std::string folder = temporaryFolder(options_);
    Descriptor file(openUnnamed(folder));
    demandRoom(inputs_.front().file->path(), folder, file.get(), total_bytes_);
    decodeAll(folder, file.get());
    descriptor_ = file.release();
  } catch (const Error& error) {
    failure_ = error.what();
    throw;
  }
}

void DecodedFile::decodeAll(const std::string& folder, int descriptor) {
  ProgressMeter progress(
      options_.watch ? options_.watch(inputs_.front().file->path()) : ProgressWatch(),
      total_bytes_);
  std::vector<std::byte> chunk(kChunkBytes);
  for (const EncodedFile& input : inputs_) {
    const std::unique_ptr<Decoder> decoder = open(input);
    uint64_t done = 0;
    const uint64_t wanted = input.skip_bytes + input.keep_bytes;
    while (done < wanted) {
      options_.stop.throwIfStopped();
      const bool skipping = done < input.skip_bytes;
      const uint64_t ahead = (skipping ? input.skip_bytes : wanted) - done;
      const auto out = std::span(chunk).first(std::min<uint64_t>(ahead, chunk.size()));
      const size_t got = decoder->read(out);
      if (!skipping) {
        append(folder, descriptor, out.first(got));
        progress.add(got);
      }
      done += got;
      if (got < out.size())
        fail("{}: {} expected, {} found{}", input.file->path(), arithmetic_, done,
             decoder->finished() ? "" : " before the compressed stream breaks off");
    }
    // Read to the end, since the checksum comes last.
    std::array<std::byte, 8> more;
    if (decoder->read(more) > 0)
      fail("{}: {} expected, the stream goes on after them", input.file->path(), arithmetic_);
    if (!decoder->finished())
      fail("{}: the compressed stream breaks off before its checksum; the file was truncated",
           input.file->path());
  }
}

void DecodedFile::read(uint64_t offset, std::span<const iovec> parts) {
  if (descriptor_ < 0) decodeOnce();
  uint64_t wanted = 0;
  for (const iovec& part : parts) wanted += part.iov_len;
  const uint64_t got = readParts(inputs_.front().file->path(), descriptor_, offset, parts);
  SLUICE_CHECK_EQ(got, wanted);
}

}  // namespace sluice

#include "io/spool.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <utility>

#include "io/inflater.h"
#include "io/text_voxels.h"
#include "src/base/bytes.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "src/base/progress.h"

namespace sluice {
namespace {

constexpr size_t kChunkBytes = 1024 * 1024;
constexpr uint64_t kMaxDeflateRatio = 1032;  // 258 bytes from two bits

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

// /var/tmp before /tmp: the latter is often memory.
std::string spoolFolder() {
  const char* const chosen = std::getenv("TMPDIR");
  if (chosen != nullptr && *chosen != '\0') return chosen;
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

void append(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0)
      failErrno(fmt::format("{}: the temporary file cannot be written; set TMPDIR to a folder "
                            "with room",
                            spoolFolder()),
                errno);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
}

}  // namespace

Spool::Spool(std::vector<EncodedFile> inputs, Codec codec, VoxelType type, std::string arithmetic)
    : inputs_(std::move(inputs)), codec_(codec), type_(type), arithmetic_(std::move(arithmetic)) {
  for (const EncodedFile& input : inputs_) {
    const uint64_t size = input.file->sizeBytes();
    const uint64_t encoded = size - std::min(size, input.offset_bytes);
    // Of text, each voxel takes a digit and, but for the last, a separator.
    const uint64_t most = codec_ == Codec::kDeflate ? encoded * kMaxDeflateRatio
                                                    : (encoded + 1) / 2 * bytesPerVoxel(type_);
    if (input.keep_bytes > most || input.skip_bytes > most - input.keep_bytes)
      fail("{}: {} expected, the {} bytes of encoded data can hold {} at most", input.file->path(),
           arithmetic_, encoded, most);
    total_bytes_ += input.keep_bytes;
  }
}

Spool::~Spool() {
  if (descriptor_ >= 0) close(descriptor_);
}

uint64_t Spool::storedBytesRead() const {
  uint64_t sum = 0;
  for (const EncodedFile& input : inputs_) sum += input.file->storedBytesRead();
  return sum;
}

std::unique_ptr<Decoder> Spool::open(const EncodedFile& input) const {
  if (codec_ == Codec::kText)
    return std::make_unique<TextVoxels>(input.file, input.offset_bytes, type_);
  return std::make_unique<Inflater>(input.file, input.offset_bytes);
}

void Spool::decodeOnce() {
  const std::lock_guard lock(mutex_);
  if (descriptor_ >= 0) return;
  if (!failure_.empty()) throw Error(failure_);
  try {
    const std::string folder = spoolFolder();
    Descriptor file(openUnnamed(folder));
    demandRoom(inputs_.front().file->path(), folder, file.get(), total_bytes_);
    decodeAll(file.get());
    descriptor_ = file.release();
  } catch (const Error& error) {
    failure_ = error.what();
    throw;
  }
}

void Spool::decodeAll(int descriptor) {
  Progress progress(fmt::format("decoding {}", inputs_.front().file->path()), total_bytes_);
  std::vector<std::byte> chunk(kChunkBytes);
  for (const EncodedFile& input : inputs_) {
    const std::unique_ptr<Decoder> decoder = open(input);
    uint64_t done = 0;
    const uint64_t wanted = input.skip_bytes + input.keep_bytes;
    while (done < wanted) {
      throwIfInterrupted();
      const bool skipping = done < input.skip_bytes;
      const uint64_t ahead = (skipping ? input.skip_bytes : wanted) - done;
      const auto out = std::span(chunk).first(std::min<uint64_t>(ahead, chunk.size()));
      const size_t got = decoder->read(out);
      if (!skipping) {
        append(descriptor, out.first(got));
        progress.add(got);
      }
      done += got;
      if (got < out.size())
        fail("{}: {} expected, {} found{}", input.file->path(), arithmetic_, done,
             decoder->finished() ? "" : " before the compressed stream breaks off");
    }
    std::array<std::byte, 8> more;
    if (decoder->read(more) > 0)
      fail("{}: {} expected, the stream goes on after them", input.file->path(), arithmetic_);
    if (!decoder->finished())
      fail("{}: the compressed stream breaks off before its checksum; the file was truncated",
           input.file->path());
  }
}

void Spool::read(uint64_t offset, std::span<const iovec> parts) {
  if (descriptor_ < 0) decodeOnce();
  uint64_t wanted = 0;
  for (const iovec& part : parts) wanted += part.iov_len;
  const uint64_t got = readParts(inputs_.front().file->path(), descriptor_, offset, parts);
  SLUICE_CHECK_EQ(got, wanted);
}

}  // namespace sluice

#include "io/zarr/packing/pack_journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "io/zarr/reading/zarr_checksums.h"
#include "src/base/error.h"

namespace sluice {
namespace {

struct Line {
  PackRecord record;
  uint64_t checksum = 0;  // XXH3 of the record
};

uint64_t checksumOf(const PackRecord& record) {
  return zarrChecksum(std::as_bytes(std::span(&record, 1)));
}

}  // namespace

PackJournal::PackJournal(const std::filesystem::path& path)
    : path_(path), file_(open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) {
  if (!file_) failErrno(fmt::format("{}: cannot be written", path.string()), errno);
}

std::vector<PackRecord> PackJournal::recover(uint64_t chunks) {
  std::vector<PackRecord> sound;
  Line line;
  const auto end = [&] { return static_cast<off_t>(sound.size() * sizeof(Line)); };
  while (pread(file_.get(), &line, sizeof line, end()) == ssize_t{sizeof line} &&
         line.checksum == checksumOf(line.record) && line.record.chunk < chunks)
    sound.push_back(line.record);
  if (ftruncate(file_.get(), end()) != 0) failErrno(path_.string(), errno);
  return sound;
}

void PackJournal::add(const PackRecord& record) {
  const Line line{record, checksumOf(record)};
  writePart(file_.get(), std::as_bytes(std::span(&line, 1)), path_);
}

void writePart(int file, std::span<const std::byte> bytes, const std::filesystem::path& path) {
  writeAll(file, bytes, fmt::format("{}: write failed", path.string()));
}

}  // namespace sluice

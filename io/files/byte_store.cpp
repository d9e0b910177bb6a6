#include "io/files/byte_store.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include "src/base/error.h"

namespace sluice {

uint64_t readParts(const std::string& path, int descriptor, uint64_t offset,
                   std::span<const iovec> parts) {
  SLUICE_CHECK_LE(parts.size(), ByteStore::kMaxParts);
  std::array<iovec, ByteStore::kMaxParts> left;
  std::copy(parts.begin(), parts.end(), left.begin());
  uint64_t got = 0;
  size_t first = 0;  // the part that is being filled
  while (first < parts.size()) {
    const ssize_t taken =
        preadv(descriptor, left.data() + first, static_cast<int>(parts.size() - first),
               static_cast<off_t>(offset + got));
    if (taken < 0 && errno == EINTR) continue;
    if (taken < 0) failErrno(fmt::format("{}: reading at offset {} failed", path, offset), errno);
    // The file's end.
    if (taken == 0) break;
    got += static_cast<uint64_t>(taken);
    size_t rest = static_cast<size_t>(taken);
    // preadv() may stop anywhere, so that the rest is asked for again.
    while (first < parts.size() && rest >= left[first].iov_len) rest -= left[first++].iov_len;
    if (rest > 0) {
      left[first].iov_base = static_cast<std::byte*>(left[first].iov_base) + rest;
      left[first].iov_len -= rest;
    }
  }
  return got;
}

}  // namespace sluice

// A trace file's bytes, unpacked if the file is compressed with gzip or Zstandard. The first bytes
// decide, whatever the name is. Memory is two small buffers and the compression's own window (at
// most 128 MiB, which is Zstandard's largest without --long), however large the file is. One thread
// a stream.
#pragma once

#include <filesystem>
#include <istream>
#include <memory>

namespace sluice::trace_internal {

// Opens `path` for reading from its start. The stream throws Error, with the path, when the file
// cannot be read, the compressed data is damaged, or it ends too early. Throws Error when the file
// cannot be opened or is packed in a way that is not read (xz, bzip2, lz4, zip).
std::unique_ptr<std::istream> openUnpacked(const std::filesystem::path& path);

// Whether the file begins as data of Zstandard do. False if it cannot be read.
bool beginsAsZstd(const std::filesystem::path& path);

// The name without the ending of a compressed file: "t.csv" for "t.csv.zst". Also the
// endings of compressions that are not read, so that the message is about these.
std::filesystem::path withoutPackedEnding(const std::filesystem::path& path);

}  // namespace sluice::trace_internal

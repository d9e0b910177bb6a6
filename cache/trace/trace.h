// Traces: the requests that a run made of the texture cache, one record a chunk request, and the
// file formats that they are kept in. Reading and writing stream; neither holds a whole trace
// unless a format forces it to (oracleGeneral, which names the next request, on writing).
//
// Our formats are lossless and end with the number of records, so that a cut file is noticed:
//   text    "sluice-trace 1 page_bytes N", then a line a record:
//           chunk pages cluster frame moved needed extended empty [level]
//           ('#' starts a comment line; the level of resolution is left out if it is 0)
//   binary  magic, page bytes, records as differences in varints, record count at the end
// Formats of other programs, which take the fields that they know and ignore the rest. A file that
// we write is read back whole, clusters and causes included. A file from another program has only
// chunk, bytes and time: pages = bytes / page bytes rounded up, all bytes are needed but the page
// rounding, and there are no clusters:
//   csv     libCacheSim's: time,obj_id,obj_size, or the order that a line of names gives; time is
//           the frame. Ours has more columns (trace_csv.cpp)
//   oracleGeneral  libCacheSim's: 24 bytes a record, little endian: u32 time, u64 id, u32 size,
//           i64 number (from 1) of the next request of this id, -1 for none. Ours has a companion
//           file, "<name>.sluice", with the fields that do not fit (trace_oracle_general.cpp)
//   din     dinero's: "label address" in hexadecimal, a line a page: address / page bytes is the
//           page. Written with label 0 and each chunk's pages in a row; we write the other fields
//           after the addresses (trace_din.cpp), and read others' files as chunks of one page
//
// Each reader or writer belongs to one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

// The bytes that one load of a chunk moves, by cause.
struct LoadBytes {
  uint64_t moved = 0;     // handed to the device
  uint64_t needed = 0;    // voxels inside object boxes: someone draws them
  uint64_t extended = 0;  // filled in by merging blocks of different thickness
  uint64_t empty = 0;     // empty voxels that trimming kept
  // The rest: whole pages beyond the chunk's voxels.
  uint64_t rounding() const { return moved - needed - extended - empty; }
  friend bool operator==(const LoadBytes&, const LoadBytes&) = default;
};

struct TraceRecord {
  uint64_t chunk = 0;
  uint32_t pages = 1;
  uint32_t cluster = 0;  // for whose drawing it was requested
  uint32_t frame = 0;
  LoadBytes bytes;
  uint32_t level = 0;  // of resolution, of the chunk's blocks; 0: the data as stored
  friend bool operator==(const TraceRecord&, const TraceRecord&) = default;
};

enum class TraceFormat { kText, kBinary, kCsv, kOracleGeneral, kDin };
// "text", "binary", "csv", "oracleGeneral", "din".
std::string_view name(TraceFormat format);
std::optional<TraceFormat> parseTraceFormat(std::string_view text);
// The format for a file's name, for writing: .txt text, .csv, .din, .oracleGeneral; anything else
// our compact binary.
TraceFormat traceFormatOf(const std::filesystem::path& path);

class TraceReader {
 public:
  virtual ~TraceReader() = default;
  // False at the end. Throws Error: "<file>:<line or record>: " with the expected and the found
  // content. Every record returned has pages in [1, 2^31], moved in [0, 2^40] and causes that add
  // up.
  virtual bool next(TraceRecord& record) = 0;
  virtual uint64_t pageBytes() const = 0;
  // Whether the records name the cluster that they are for. Else their cluster is 0 and means
  // nothing.
  virtual bool carriesClusters() const = 0;
  // Notes on the file for a person, a line each, known when next() has returned false.
  virtual const std::vector<std::string>& warnings() const = 0;
};

// Reads from `in`; `label` names it in errors. `page_bytes` is for the formats that do not contain
// it. Throws Error when the beginning is not of this format. Requires: page_bytes > 0.
std::unique_ptr<TraceReader> makeTraceReader(std::unique_ptr<std::istream> in, std::string label,
                                             TraceFormat format, uint64_t page_bytes);
// Opens a file, unpacking it if its content is compressed with gzip or Zstandard. Without a format,
// ours are known by their first bytes and the others by extension (.csv, .din, .oracleGeneral with
// anything after it, .bin), ignoring .gz and .zst. A pipe is refused, never waited for. Throws
// Error.
std::unique_ptr<TraceReader> openTrace(const std::filesystem::path& path,
                                       std::optional<TraceFormat> format = std::nullopt,
                                       uint64_t page_bytes = 4096);

// Whether openTrace() would take a file for a trace: by a foreign format's name, or by our first
// bytes. A .bin is one if it begins as oracleGeneral, since volumes have that name, too. A pipe is
// none, and not waited for.
bool isTraceFile(const std::filesystem::path& path);

class TraceWriter {
 public:
  virtual ~TraceWriter() = default;
  // Requires: the bounds that TraceReader::next promises. Throws Error when the disk is full, or a
  // number is too large for the format.
  virtual void write(const TraceRecord& record) = 0;
  // Writes the remaining records. The file (and oracleGeneral's companion) appears now, or never.
  virtual void finish() = 0;
};

// Every file that a writer of this format makes: `path`, and oracleGeneral's companion.
std::vector<std::filesystem::path> traceFiles(const std::filesystem::path& path,
                                              TraceFormat format);
// Throws Error when the name promises a compressed file.
void refuseCompressed(const std::filesystem::path& path);
// Throws as refuseCompressed() does, and Error when the folder cannot be written.
std::unique_ptr<TraceWriter> makeTraceWriter(const std::filesystem::path& path, TraceFormat format,
                                             uint64_t page_bytes);

// A whole trace in memory.
struct Trace {
  uint64_t page_bytes = 4096;
  std::vector<TraceRecord> records;
  bool carries_clusters = true;
};
Trace readAll(TraceReader& reader);

}  // namespace sluice

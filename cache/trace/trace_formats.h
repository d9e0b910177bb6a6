// The pieces that trace readers and writers share, a source a format; not for other folders.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cache/trace/trace.h"
#include "cache/trace/trace_input.h"
#include "src/base/error.h"
#include "src/base/files/atomic_file.h"

namespace sluice::trace_internal {

constexpr std::string_view kTextMagic = "sluice-trace 1 page_bytes ";
constexpr std::string_view kBinaryMagic = "SLTRACE\x01";
// Starts the number of records at the end of a text file of ours.
constexpr std::string_view kRecordsWord = "records ";
constexpr uint64_t kMaxPages = uint64_t{1} << 31;
constexpr uint64_t kMaxBytes = uint64_t{1} << 40;

// The fault of a record, or nullptr.
const char* problemOf(const TraceRecord& record);
// Pages and causes for a load of `bytes` bytes of which only the size is known.
TraceRecord recordOfSize(uint64_t chunk, uint64_t bytes, uint64_t frame, uint64_t page_bytes);
constexpr uint64_t kMaxLevel = 63;
// chunk, pages, cluster, frame, moved, needed, extended, empty, level: a record as text has it.
using RecordFields = std::array<uint64_t, 9>;
// Takes a record off the front of `text`; its level may be missing and is 0 then. False when it
// does not start with one.
bool takeRecord(std::string_view& text, RecordFields& fields);
// Throws Error, starting with "<label>:<line>:" and ending with `line`'s beginning, when they
// exceed a record's limits.
TraceRecord recordOf(const RecordFields& fields, const TraceInput& in, std::string_view line);
std::string textOf(const TraceRecord& record);
// The text for an error line: quoted, unprintable bytes as '?', cut after 40.
std::string excerpt(std::string_view text);

// The common part of all readers.
class Reader : public TraceReader {
 public:
  Reader(std::unique_ptr<std::istream> in, std::string label, uint64_t page_bytes)
      : in_(std::move(in), std::move(label)), page_bytes_(page_bytes) {}
  uint64_t pageBytes() const override { return page_bytes_; }
  bool carriesClusters() const override { return carries_clusters_; }
  const std::vector<std::string>& warnings() const override { return warnings_; }

 protected:
  // Called at the end of a file of ours, which contains its number of records.
  void checkPromised(uint64_t promised) const {
    if (promised != records_)
      fail("{}: expected {} records, found {}; record the trace again", in_.label(), promised,
           records_);
  }
  [[noreturn]] void failCut() const {
    fail("{}: the file ends in the middle, after {} records; record the trace again", in_.label(),
         records_);
  }
  // Called at the end of a file of lines that does not contain their number.
  void warnIfCut() {
    if (!in_.lineEnded())
      warnings_.push_back(fmt::format("{}:{}: the last line has no end; the file may be cut",
                                      in_.label(), in_.lineNumber()));
  }

  // A record of which only the size is known: the record before, if it repeats. `place` is its
  // place in errors.
  template <class Place>
  const TraceRecord& sized(uint64_t chunk, uint64_t bytes, uint64_t frame, Place&& place) {
    if (bytes != sized_bytes_ || !has_sized_) {
      sized_ = recordOfSize(chunk, bytes, frame, page_bytes_);
      if (const char* problem = problemOf(sized_))
        fail("{}: expected {}, found {} B in pages of {} B; take larger pages", place(), problem,
             bytes, page_bytes_);
      sized_bytes_ = bytes;
      has_sized_ = true;
    }
    sized_.chunk = chunk;
    sized_.frame = static_cast<uint32_t>(std::min<uint64_t>(frame, UINT32_MAX));
    return sized_;
  }

  TraceInput in_;
  uint64_t page_bytes_;
  uint64_t records_ = 0;  // read so far
  bool carries_clusters_ = true;
  std::vector<std::string> warnings_;

 private:
  TraceRecord sized_;
  uint64_t sized_bytes_ = 0;
  bool has_sized_ = false;
};

// Small writes gathered for an AtomicFile.
class OutputBuffer {
 public:
  explicit OutputBuffer(const std::filesystem::path& path) : file_(path) {}
  // Throws Error, as commit() does, if the file cannot be written.
  void append(std::string_view text) {
    pending_ += text;
    if (pending_.size() >= kFlushBytes) flush();
  }
  void commit() {
    flush();
    file_.commit();
  }

 private:
  static constexpr size_t kFlushBytes = 1 << 16;
  void flush() {
    file_.write(std::string_view(pending_));
    pending_.clear();
  }
  AtomicFile file_;
  std::string pending_;
};

// The common part of all writers.
class Writer : public TraceWriter {
 public:
  Writer(const std::filesystem::path& path, uint64_t page_bytes)
      : out_(path), path_(path.string()), page_bytes_(page_bytes) {}
  void finish() override { out_.commit(); }

 protected:
  OutputBuffer out_;
  const std::string path_;
  const uint64_t page_bytes_;
  uint64_t records_ = 0;  // written so far
};

using Stream = std::unique_ptr<std::istream>;
// `label`: the file's name in messages.
std::unique_ptr<TraceReader> makeTextReader(Stream in, std::string label);
std::unique_ptr<TraceReader> makeBinaryReader(Stream in, std::string label);
std::unique_ptr<TraceReader> makeCsvReader(Stream in, std::string label, uint64_t page_bytes);
std::unique_ptr<TraceReader> makeDinReader(Stream in, std::string label, uint64_t page_bytes);
// `companion`: the same trace with the fields that the format lacks, or nullptr.
std::unique_ptr<TraceReader> makeOracleGeneralReader(Stream in, std::string label,
                                                     uint64_t page_bytes,
                                                     std::unique_ptr<TraceReader> companion);
// The companion of an oracleGeneral file: ".sluice" after the whole name.
std::filesystem::path companionOf(const std::filesystem::path& path);

// The file gets its name at finish(). All throw Error if it cannot be written.
std::unique_ptr<TraceWriter> makeTextWriter(const std::filesystem::path& path, uint64_t page_bytes);
std::unique_ptr<TraceWriter> makeBinaryWriter(const std::filesystem::path& path,
                                              uint64_t page_bytes);
std::unique_ptr<TraceWriter> makeCsvWriter(const std::filesystem::path& path, uint64_t page_bytes);
std::unique_ptr<TraceWriter> makeDinWriter(const std::filesystem::path& path, uint64_t page_bytes);
std::unique_ptr<TraceWriter> makeOracleGeneralWriter(const std::filesystem::path& path,
                                                     uint64_t page_bytes);

}  // namespace sluice::trace_internal

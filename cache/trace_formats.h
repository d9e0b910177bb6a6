// The pieces that trace readers and writers share; not for other folders.
#pragma once

#include <charconv>
#include <cstdint>
#include <istream>
#include <memory>
#include <string>
#include <string_view>

#include "cache/trace.h"
#include "src/base/atomic_file.h"
#include "src/base/error.h"

namespace sluice::trace_internal {

constexpr std::string_view kTextMagic = "sluice-trace 1 page_bytes ";
constexpr std::string_view kBinaryMagic = "SLTRACE\x01";
constexpr uint64_t kMaxPages = uint64_t{1} << 31;
constexpr uint64_t kMaxBytes = uint64_t{1} << 40;
// Leads a record or the end in the binary format.
enum : uint8_t { kEnd = 0, kRecord = 1, kSameVisit = 2, kSameShape = 4 };

// What is wrong with a record, or nullptr.
const char* problemOf(const TraceRecord& record);
// pages and causes for a load of `bytes` of which only the size is known.
TraceRecord recordOfSize(uint64_t chunk, uint64_t bytes, uint64_t frame, uint64_t page_bytes);
// For an error line: quoted, unprintable bytes as '?', cut after 40.
std::string excerpt(std::string_view text);

// The whole of `text` as a number; false when it is anything else.
template <class T>
bool parseNumber(std::string_view text, T& value, int base = 10) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return error == std::errc() && end == text.data() + text.size();
}

// Small writes gathered for an AtomicFile.
class OutputBuffer {
 public:
  explicit OutputBuffer(const std::filesystem::path& path) : file_(path) {}
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

std::unique_ptr<TraceReader> makeTextReader(std::unique_ptr<std::istream> in, std::string label);
std::unique_ptr<TraceReader> makeBinaryReader(std::unique_ptr<std::istream> in, std::string label);
std::unique_ptr<TraceReader> makeForeignReader(std::unique_ptr<std::istream> in, std::string label,
                                               TraceFormat format, uint64_t page_bytes);

}  // namespace sluice::trace_internal

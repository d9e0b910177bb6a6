// libCacheSim's oracleGeneral: 24 bytes a record, which has no room for clusters. So what we write
// comes with a companion, the trace in our binary format in a second file; the reader goes through
// both and refuses a companion that belongs to another trace.
#include <bit>
#include <cstring>
#include <unordered_map>

#include "cache/trace/trace_formats.h"

namespace sluice::trace_internal {
namespace {

constexpr size_t kRecordBytes = 24;

template <class T>
T littleEndian(std::string_view raw, size_t at) {
  static_assert(std::endian::native == std::endian::little);
  T value;
  std::memcpy(&value, raw.data() + at, sizeof value);
  return value;
}

void putLittleEndian(std::string& out, uint64_t value, int count) {
  for (int i = 0; i < count; ++i) out += static_cast<char>(value >> (8 * i));
}

class OracleGeneralReader final : public Reader {
 public:
  OracleGeneralReader(Stream in, std::string label, uint64_t page_bytes,
                      std::unique_ptr<TraceReader> companion)
      : Reader(std::move(in), std::move(label), page_bytes), companion_(std::move(companion)) {
    carries_clusters_ = companion_ != nullptr;
    if (companion_) page_bytes_ = companion_->pageBytes();
  }

  bool next(TraceRecord& record) override {
    const std::string_view raw = in_.bytes(kRecordBytes);
    if (raw.empty()) {
      finish(record);
      return false;
    }
    ++records_;
    if (raw.size() != kRecordBytes)
      fail("{}: record {}: expected 24 bytes, found {}; the file is cut or not oracleGeneral",
           in_.label(), records_, raw.size());
    const auto time = littleEndian<uint32_t>(raw, 0), bytes = littleEndian<uint32_t>(raw, 12);
    const auto id = littleEndian<uint64_t>(raw, 4);
    const auto next_request = littleEndian<int64_t>(raw, 16);
    checkNext(next_request);
    if (next_request != INT64_MAX) furthest_ = std::max(furthest_, next_request);
    if (companion_) {
      if (!companion_->next(record) || record.chunk != id || record.frame != time ||
          record.bytes.moved != bytes)
        failCompanion();
      return true;
    }
    record =
        sized(id, bytes, time, [&] { return fmt::format("{}: record {}", in_.label(), records_); });
    return true;
  }

 private:
  // The next request comes later, so bytes that are something else are soon noticed. Some programs
  // count requests from 0, and write 0 when they do not know.
  void checkNext(int64_t next_request) const {
    if (next_request >= -1 &&
        (next_request <= 0 || static_cast<uint64_t>(next_request) >= records_))
      return;
    fail(
        "{}: record {}: expected the number of a later request or -1, found {}; is the file "
        "oracleGeneral?",
        in_.label(), records_, next_request);
  }
  void finish(TraceRecord& record) {
    if (companion_) {
      if (companion_->next(record)) failCompanion();
    } else if (furthest_ > 0 && static_cast<uint64_t>(furthest_) > records_) {
      warnings_.push_back(
          fmt::format("{}: requests name {} as their next one, and the file ends after {}; it may "
                      "be cut",
                      in_.label(), furthest_, records_));
    }
  }
  [[noreturn]] void failCompanion() const {
    fail(
        "{}: record {} is not that of {}; record the trace again, or delete the latter to read "
        "the former alone",
        in_.label(), records_, companionOf(in_.label()).string());
  }

  const std::unique_ptr<TraceReader> companion_;
  int64_t furthest_ = 0;  // the last request that one names as its next
};

class OracleGeneralWriter final : public Writer {
 public:
  OracleGeneralWriter(const std::filesystem::path& path, uint64_t page_bytes)
      : Writer(path, page_bytes), companion_(makeBinaryWriter(companionOf(path), page_bytes)) {}

  void write(const TraceRecord& r) override {
    if (r.bytes.moved > UINT32_MAX)
      fail("{}: chunk {} has {} B, oracleGeneral takes at most 2^32 - 1; write text or binary",
           path_, r.chunk, r.bytes.moved);
    companion_->write(r);
    written_.push_back({r.frame, r.chunk, static_cast<uint32_t>(r.bytes.moved), -1});
    const auto [last, is_new] = last_of_.try_emplace(r.chunk, written_.size());
    if (!is_new) {
      written_[last->second - 1].next = static_cast<int64_t>(written_.size());
      last->second = written_.size();
    }
  }
  void finish() override {
    // Written at the end, since a record names the next request of its chunk.
    for (const Record& r : written_) {
      std::string raw;
      putLittleEndian(raw, r.time, 4);
      putLittleEndian(raw, r.id, 8);
      putLittleEndian(raw, r.size, 4);
      putLittleEndian(raw, static_cast<uint64_t>(r.next), 8);
      out_.append(raw);
    }
    companion_->finish();
    Writer::finish();
  }

 private:
  struct Record {
    uint32_t time;
    uint64_t id;
    uint32_t size;
    int64_t next;
  };
  const std::unique_ptr<TraceWriter> companion_;
  std::vector<Record> written_;
  std::unordered_map<uint64_t, size_t> last_of_;  // id -> number of its last record, from 1
};

}  // namespace

std::filesystem::path companionOf(const std::filesystem::path& path) {
  return path.string() + ".sluice";
}

std::unique_ptr<TraceReader> makeOracleGeneralReader(Stream in, std::string label,
                                                     uint64_t page_bytes,
                                                     std::unique_ptr<TraceReader> companion) {
  return std::make_unique<OracleGeneralReader>(std::move(in), std::move(label), page_bytes,
                                               std::move(companion));
}
std::unique_ptr<TraceWriter> makeOracleGeneralWriter(const std::filesystem::path& path,
                                                     uint64_t page_bytes) {
  return std::make_unique<OracleGeneralWriter>(path, page_bytes);
}

}  // namespace sluice::trace_internal

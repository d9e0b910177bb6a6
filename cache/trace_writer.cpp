// Writers of all trace formats.
#include <unordered_map>
#include <utility>

#include "cache/key_table.h"
#include "cache/trace_formats.h"

namespace sluice {
namespace {

using trace_internal::OutputBuffer;

class Writer : public TraceWriter {
 public:
  Writer(const std::filesystem::path& path, uint64_t page_bytes)
      : out_(path), path_(path.string()), page_bytes_(page_bytes) {}
  void finish() override { out_.commit(); }

 protected:
  OutputBuffer out_;
  const std::string path_;
  const uint64_t page_bytes_;
};

class TextWriter final : public Writer {
 public:
  TextWriter(const std::filesystem::path& path, uint64_t page_bytes) : Writer(path, page_bytes) {
    out_.append(fmt::format(
        "{}{}\n# chunk pages cluster frame moved needed extended empty (bytes of a load)\n",
        trace_internal::kTextMagic, page_bytes));
  }
  void write(const TraceRecord& r) override {
    out_.append(fmt::format("{} {} {} {} {} {} {} {}\n", r.chunk, r.pages, r.cluster, r.frame,
                            r.bytes.moved, r.bytes.needed, r.bytes.extended, r.bytes.empty));
  }
};

class BinaryWriter final : public Writer {
 public:
  BinaryWriter(const std::filesystem::path& path, uint64_t page_bytes) : Writer(path, page_bytes) {
    out_.append(trace_internal::kBinaryMagic);
    putVarint(page_bytes);
    out_.append(bytes_);
  }
  void write(const TraceRecord& r) override {
    const bool same_visit = r.cluster == last_.cluster && r.frame == last_.frame;
    const bool same_shape = r.pages == last_.pages && r.bytes == last_.bytes && records_ > 0;
    bytes_.assign(1, static_cast<char>(trace_internal::kRecord |
                                       (same_visit ? trace_internal::kSameVisit : 0) |
                                       (same_shape ? trace_internal::kSameShape : 0)));
    putVarint(zigzag(r.chunk - last_.chunk));
    if (!same_visit) {
      putVarint(zigzag(uint64_t{r.cluster} - last_.cluster));
      putVarint(zigzag(uint64_t{r.frame} - last_.frame));
    }
    if (!same_shape) {
      putVarint(r.pages);
      putVarint(r.bytes.moved);
      putVarint(r.bytes.needed);
      putVarint(r.bytes.extended);
      putVarint(r.bytes.empty);
    }
    out_.append(bytes_);
    last_ = r;
    ++records_;
  }
  void finish() override {
    bytes_.assign(1, static_cast<char>(trace_internal::kEnd));
    putVarint(records_);
    out_.append(bytes_);
    Writer::finish();
  }

 private:
  void putVarint(uint64_t value) {
    for (; value >= 128; value >>= 7) bytes_ += static_cast<char>(value | 128);
    bytes_ += static_cast<char>(value);
  }
  // A difference as a signed number, small ones of either sign in few bits.
  static uint64_t zigzag(uint64_t difference) {
    return (difference << 1) ^ (difference >> 63 != 0 ? ~uint64_t{0} : 0);
  }

  std::string bytes_;
  TraceRecord last_;
  uint64_t records_ = 0;
};

class CsvWriter final : public Writer {
 public:
  CsvWriter(const std::filesystem::path& path, uint64_t page_bytes) : Writer(path, page_bytes) {
    out_.append("time,obj_id,obj_size\n");
  }
  void write(const TraceRecord& r) override {
    out_.append(fmt::format("{},{},{}\n", r.frame, r.chunk, r.bytes.moved));
  }
};

class OracleGeneralWriter final : public Writer {
 public:
  using Writer::Writer;
  void write(const TraceRecord& r) override {
    if (r.bytes.moved > UINT32_MAX)
      fail("{}: chunk {} has {} B, oracleGeneral takes at most 2^32 - 1; write text or binary",
           path_, r.chunk, r.bytes.moved);
    records_.push_back({r.frame, r.chunk, static_cast<uint32_t>(r.bytes.moved), -1});
    const auto [last, is_new] = last_of_.try_emplace(r.chunk, records_.size());
    if (!is_new) {
      records_[last->second - 1].next = static_cast<int64_t>(records_.size());
      last->second = records_.size();
    }
  }
  void finish() override {
    for (const Record& r : records_) {
      std::string raw;
      putLittleEndian(raw, r.time, 4);
      putLittleEndian(raw, r.id, 8);
      putLittleEndian(raw, r.size, 4);
      putLittleEndian(raw, static_cast<uint64_t>(r.next), 8);
      out_.append(raw);
    }
    Writer::finish();
  }

 private:
  struct Record {
    uint32_t time;
    uint64_t id;
    uint32_t size;
    int64_t next;
  };
  static void putLittleEndian(std::string& out, uint64_t value, int count) {
    for (int i = 0; i < count; ++i) out += static_cast<char>(value >> (8 * i));
  }
  std::vector<Record> records_;
  std::unordered_map<uint64_t, size_t> last_of_;  // id -> number of its last record, from 1
};

class DinWriter final : public Writer {
 public:
  using Writer::Writer;
  void write(const TraceRecord& r) override {
    const uint32_t key = keys_.insert(r.chunk);
    if (key == first_page_.size()) {
      first_page_.push_back(next_page_);
      pages_.push_back(r.pages);
      next_page_ += r.pages;
    }
    if (r.pages != pages_[key])
      fail("{}: chunk {} was requested with {} pages and then with {}; din cannot tell them apart",
           path_, r.chunk, pages_[key], r.pages);
    for (uint64_t page = 0; page < r.pages; ++page)
      out_.append(fmt::format("0 {:x}\n", (first_page_[key] + page) * page_bytes_));
  }

 private:
  KeyTable keys_;
  std::vector<uint64_t> first_page_;  // by key
  std::vector<uint32_t> pages_;       // by key
  uint64_t next_page_ = 0;
};

}  // namespace

std::unique_ptr<TraceWriter> makeTraceWriter(const std::filesystem::path& path, TraceFormat format,
                                             uint64_t page_bytes) {
  SLUICE_CHECK_LT(uint64_t{0}, page_bytes);
  switch (format) {
    case TraceFormat::kText:
      return std::make_unique<TextWriter>(path, page_bytes);
    case TraceFormat::kBinary:
      return std::make_unique<BinaryWriter>(path, page_bytes);
    case TraceFormat::kCsv:
      return std::make_unique<CsvWriter>(path, page_bytes);
    case TraceFormat::kOracleGeneral:
      return std::make_unique<OracleGeneralWriter>(path, page_bytes);
    case TraceFormat::kDin:
      break;
  }
  return std::make_unique<DinWriter>(path, page_bytes);
}

}  // namespace sluice

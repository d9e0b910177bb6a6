// Readers of libCacheSim's csv and oracleGeneral and of dinero's din.
#include <array>
#include <cctype>
#include <utility>

#include "cache/trace_formats.h"

namespace sluice::trace_internal {
namespace {

std::string_view trim(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())))
    text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())))
    text.remove_suffix(1);
  return text;
}

// Takes what is before the first `delimiter` off `rest`.
std::string_view takeField(std::string_view& rest, char delimiter) {
  const size_t end = std::min(rest.find(delimiter), rest.size());
  const std::string_view field = trim(rest.substr(0, end));
  rest.remove_prefix(std::min(rest.size(), end + 1));
  return field;
}

class ForeignReader : public TraceReader {
 public:
  ForeignReader(std::unique_ptr<std::istream> in, std::string label, uint64_t page_bytes)
      : in_(std::move(in)), label_(std::move(label)), page_bytes_(page_bytes) {}
  uint64_t pageBytes() const override { return page_bytes_; }

 protected:
  // The next line that is not empty, or false.
  bool nextLine(std::string& line) {
    while (std::getline(*in_, line)) {
      ++number_;
      if (!trim(line).empty()) return true;
    }
    return false;
  }
  TraceRecord checked(const TraceRecord& record) const {
    if (const char* problem = problemOf(record))
      fail("{}:{}: expected {}, found {} B in pages of {} B; take larger pages", label_, number_,
           problem, record.bytes.needed, page_bytes_);
    return record;
  }

  const std::unique_ptr<std::istream> in_;
  const std::string label_;
  const uint64_t page_bytes_;
  uint64_t number_ = 0;  // line or record read last, from 1
};

class CsvReader final : public ForeignReader {
 public:
  using ForeignReader::ForeignReader;

  bool next(TraceRecord& record) override {
    std::string line;
    while (nextLine(line)) {
      std::string_view rest = line;
      std::string_view time_text = takeField(rest, ',');
      uint64_t time = 0, id = 0, bytes = 0;
      time_text = time_text.substr(0, time_text.find('.'));  // fractions of a second are dropped
      const bool parsed = parseNumber(time_text, time) && parseNumber(takeField(rest, ','), id) &&
                          parseNumber(takeField(rest, ','), bytes);
      if (!parsed && number_ == 1) continue;  // the header
      if (!parsed || bytes > kMaxBytes)
        fail("{}:{}: expected time,obj_id,obj_size as whole numbers, found {}", label_, number_,
             excerpt(line));
      record = checked(recordOfSize(id, bytes, time, page_bytes_));
      return true;
    }
    return false;
  }
};

class OracleGeneralReader final : public ForeignReader {
 public:
  using ForeignReader::ForeignReader;

  bool next(TraceRecord& record) override {
    std::array<char, 24> raw{};
    in_->read(raw.data(), raw.size());
    const auto got = static_cast<size_t>(in_->gcount());
    if (got == 0) return false;
    ++number_;
    if (got != raw.size())
      fail("{}: record {}: expected 24 bytes, found {}; the file is cut or not oracleGeneral",
           label_, number_, got);
    record = checked(recordOfSize(littleEndian(&raw[4], 8), littleEndian(&raw[12], 4),
                                  littleEndian(&raw[0], 4), page_bytes_));
    return true;
  }

 private:
  static uint64_t littleEndian(const char* bytes, int count) {
    uint64_t value = 0;
    for (int i = count - 1; i >= 0; --i) value = (value << 8) | static_cast<uint8_t>(bytes[i]);
    return value;
  }
};

class DinReader final : public ForeignReader {
 public:
  using ForeignReader::ForeignReader;

  bool next(TraceRecord& record) override {
    std::string line;
    if (!nextLine(line)) return false;
    std::string_view rest = trim(line);
    const std::string_view label = takeField(rest, ' ');
    std::string_view address_text = takeField(rest = trim(rest), ' ');
    if (address_text.starts_with("0x")) address_text.remove_prefix(2);
    uint64_t address = 0;
    if (label.size() != 1 || label[0] < '0' || label[0] > '2' ||
        !parseNumber(address_text, address, 16))
      fail("{}:{}: expected a label 0 to 2 and a hexadecimal address, found {}", label_, number_,
           excerpt(line));
    record = checked(recordOfSize(address / page_bytes_, page_bytes_, 0, page_bytes_));
    return true;
  }
};

}  // namespace

std::unique_ptr<TraceReader> makeForeignReader(std::unique_ptr<std::istream> in, std::string label,
                                               TraceFormat format, uint64_t page_bytes) {
  if (page_bytes > kMaxBytes)
    fail("{}: expected pages of 1 to 2^40 B, found {}", label, page_bytes);
  if (format == TraceFormat::kCsv)
    return std::make_unique<CsvReader>(std::move(in), std::move(label), page_bytes);
  if (format == TraceFormat::kDin)
    return std::make_unique<DinReader>(std::move(in), std::move(label), page_bytes);
  SLUICE_CHECK(format == TraceFormat::kOracleGeneral);
  return std::make_unique<OracleGeneralReader>(std::move(in), std::move(label), page_bytes);
}

}  // namespace sluice::trace_internal

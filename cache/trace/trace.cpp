#include "cache/trace/trace.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "cache/trace/decompressed_file.h"
#include "cache/trace/trace_formats.h"

namespace sluice {
namespace trace_internal {

const char* problemOf(const TraceRecord& record) {
  if (record.pages < 1 || record.pages > kMaxPages) return "pages from 1 to 2^31";
  const LoadBytes& b = record.bytes;
  if (b.moved > kMaxBytes) return "at most 2^40 bytes moved";
  // Each is compared first, so that the sum cannot wrap.
  if (b.needed > b.moved || b.extended > b.moved || b.empty > b.moved ||
      b.needed + b.extended + b.empty > b.moved)
    return "needed, extended and empty bytes within the bytes moved";
  if (record.level > kMaxLevel) return "levels from 0 to 63";
  return nullptr;
}

TraceRecord recordOfSize(uint64_t chunk, uint64_t bytes, uint64_t frame, uint64_t page_bytes) {
  TraceRecord record;
  record.chunk = chunk;
  record.frame = static_cast<uint32_t>(std::min<uint64_t>(frame, UINT32_MAX));
  const uint64_t pages = bytes / page_bytes + (bytes % page_bytes != 0 ? 1 : 0);
  // A request of no bytes takes a page all the same.
  record.pages = static_cast<uint32_t>(std::clamp<uint64_t>(pages, 1, UINT32_MAX));
  record.bytes.moved = record.pages * page_bytes;
  record.bytes.needed = bytes;
  return record;
}

bool takeRecord(std::string_view& text, RecordFields& fields) {
  const std::span<uint64_t> always(fields.data(), fields.size() - 1);
  if (!takeNumbers(text, always)) return false;
  fields.back() = 0;
  // The level stands there only if it is not 0, see textOf().
  const bool has_level = text.size() > 1 && text[0] == ' ' && text[1] >= '0' && text[1] <= '9';
  return !has_level || (takeCharacter(text, ' ') && takeNumber(text, fields.back()));
}

TraceRecord recordOf(const RecordFields& v, const TraceInput& in, std::string_view line) {
  if (v[1] > kMaxPages || v[2] > UINT32_MAX || v[3] > UINT32_MAX)
    fail("{}:{}: expected pages to 2^31, cluster and frame to 2^32 - 1, found {}", in.label(),
         in.lineNumber(), excerpt(line));
  const TraceRecord record{v[0],
                           static_cast<uint32_t>(v[1]),
                           static_cast<uint32_t>(v[2]),
                           static_cast<uint32_t>(v[3]),
                           {v[4], v[5], v[6], v[7]},
                           static_cast<uint32_t>(std::min<uint64_t>(v[8], UINT32_MAX))};
  if (const char* problem = problemOf(record))
    fail("{}:{}: expected {}, found {}", in.label(), in.lineNumber(), problem, excerpt(line));
  return record;
}

std::string textOf(const TraceRecord& r) {
  const std::string level = r.level == 0 ? "" : fmt::format(" {}", r.level);
  return fmt::format("{} {} {} {} {} {} {} {}{}", r.chunk, r.pages, r.cluster, r.frame,
                     r.bytes.moved, r.bytes.needed, r.bytes.extended, r.bytes.empty, level);
}

std::string excerpt(std::string_view text) {
  std::string out = "'";
  for (const char c : text.substr(0, 40)) out += c >= 32 && c < 127 ? c : '?';
  if (text.size() > 40) out += "...";
  return out + "'";
}

}  // namespace trace_internal

namespace {

constexpr std::array kFormatNames{
    std::pair{TraceFormat::kText, "text"}, std::pair{TraceFormat::kBinary, "binary"},
    std::pair{TraceFormat::kCsv, "csv"}, std::pair{TraceFormat::kOracleGeneral, "oracleGeneral"},
    std::pair{TraceFormat::kDin, "din"}};

// Our own format, if the content begins as one does.
std::optional<TraceFormat> formatByContent(const std::filesystem::path& path) {
  const auto in = trace_internal::openUnpacked(path);
  std::array<char, 8> head{};
  in->read(head.data(), head.size());
  const std::string_view start(head.data(), static_cast<size_t>(in->gcount()));
  if (start == trace_internal::kBinaryMagic) return TraceFormat::kBinary;
  if (trace_internal::kTextMagic.starts_with(start) && start.size() == head.size())
    return TraceFormat::kText;
  return std::nullopt;
}

// A format that others write, by the name's endings; .gz and .zst are passed over.
std::optional<TraceFormat> formatByName(const std::filesystem::path& path) {
  const std::string file = trace_internal::withoutPackedEnding(path).filename().string();
  if (file.ends_with(".csv")) return TraceFormat::kCsv;
  if (file.ends_with(".din")) return TraceFormat::kDin;
  if (file.find(".oracleGeneral") != std::string::npos) return TraceFormat::kOracleGeneral;
  return std::nullopt;
}

// .bin, which other files have, too.
bool mayBeOracleGeneral(const std::filesystem::path& path) {
  return trace_internal::withoutPackedEnding(path).extension() == ".bin";
}

// Whether each of the first records names a later request of its chunk, or that there is none.
bool beginsAsOracleGeneral(const std::filesystem::path& path) {
  constexpr int64_t kLooksAt = 16, kMostRequests = int64_t{1} << 40;
  const auto in = trace_internal::openUnpacked(path);
  std::array<unsigned char, 24> record{};
  int64_t count = 0;
  for (; count < kLooksAt; ++count) {
    in->read(reinterpret_cast<char*>(record.data()), record.size());
    if (in->gcount() != static_cast<std::streamsize>(record.size())) break;
    uint64_t next = 0;
    for (size_t i = 0; i < sizeof next; ++i) next |= uint64_t{record[16 + i]} << (8 * i);
    const auto request = static_cast<int64_t>(next);
    if (request != -1 && (request <= count || request > kMostRequests)) return false;
  }
  return count > 0;
}

void refuseWhatIsNoFile(const std::filesystem::path& path) {
  std::error_code none;
  const std::filesystem::file_status status = std::filesystem::status(path, none);
  // The format is recognized by the first bytes, which a pipe gives only once.
  if (std::filesystem::is_directory(status))
    fail("{}: expected a trace file, found a folder", path.string());
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    fail("{}: expected a trace file, found a pipe or a device; copy its contents into a file",
         path.string());
}

}  // namespace

std::string_view name(TraceFormat format) {
  for (const auto& [f, text] : kFormatNames) {
    if (f == format) return text;
  }
  return "?";
}

std::optional<TraceFormat> parseTraceFormat(std::string_view text) {
  for (const auto& [f, known] : kFormatNames) {
    if (known == text) return f;
  }
  return std::nullopt;
}

TraceFormat traceFormatOf(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".txt") return TraceFormat::kText;
  if (extension == ".csv") return TraceFormat::kCsv;
  if (extension == ".din") return TraceFormat::kDin;
  if (extension == ".oracleGeneral") return TraceFormat::kOracleGeneral;
  return TraceFormat::kBinary;
}

namespace {

// `companion` is for oracleGeneral.
std::unique_ptr<TraceReader> readerOf(std::unique_ptr<std::istream> in, std::string label,
                                      TraceFormat format, uint64_t page_bytes,
                                      std::unique_ptr<TraceReader> companion) {
  using namespace trace_internal;
  SLUICE_CHECK_LT(uint64_t{0}, page_bytes);
  if (page_bytes > kMaxBytes)
    fail("{}: expected pages of 1 to 2^40 B, found {}", label, page_bytes);
  switch (format) {
    case TraceFormat::kText:
      return makeTextReader(std::move(in), std::move(label));
    case TraceFormat::kBinary:
      return makeBinaryReader(std::move(in), std::move(label));
    case TraceFormat::kCsv:
      return makeCsvReader(std::move(in), std::move(label), page_bytes);
    case TraceFormat::kDin:
      return makeDinReader(std::move(in), std::move(label), page_bytes);
    case TraceFormat::kOracleGeneral:
      break;
  }
  return makeOracleGeneralReader(std::move(in), std::move(label), page_bytes, std::move(companion));
}

}  // namespace

std::unique_ptr<TraceReader> makeTraceReader(std::unique_ptr<std::istream> in, std::string label,
                                             TraceFormat format, uint64_t page_bytes) {
  return readerOf(std::move(in), std::move(label), format, page_bytes, nullptr);
}

std::unique_ptr<TraceReader> openTrace(const std::filesystem::path& path,
                                       std::optional<TraceFormat> format, uint64_t page_bytes) {
  refuseWhatIsNoFile(path);
  if (!format) format = formatByContent(path);
  if (!format) format = formatByName(path);
  if (!format && mayBeOracleGeneral(path)) format = TraceFormat::kOracleGeneral;
  if (!format)
    fail(
        "{}: expected a trace (text, binary, .csv, .oracleGeneral, .bin or .din), found neither "
        "our first bytes nor a known extension; name the format",
        path.string());
  std::unique_ptr<TraceReader> companion;
  // A packed trace may have its companion under either name.
  if (format == TraceFormat::kOracleGeneral)
    for (const auto& name : {path, trace_internal::withoutPackedEnding(path)}) {
      std::error_code none;
      const std::filesystem::path beside = trace_internal::companionOf(name);
      if (companion || !std::filesystem::exists(beside, none)) continue;
      companion = openTrace(beside, TraceFormat::kBinary, page_bytes);
    }
  return readerOf(trace_internal::openUnpacked(path), path.string(), *format, page_bytes,
                  std::move(companion));
}

bool isTraceFile(const std::filesystem::path& path) {
  if (formatByName(path)) return true;
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return false;
  try {
    return formatByContent(path).has_value() ||
           (mayBeOracleGeneral(path) && beginsAsOracleGeneral(path));
  } catch (const Error&) {
    // No volume is compressed with Zstandard as a whole, so that this is a damaged trace. Others
    // are for a volume's reader to identify.
    return trace_internal::beginsAsZstd(path);
  }
}

std::vector<std::filesystem::path> traceFiles(const std::filesystem::path& path,
                                              TraceFormat format) {
  if (format != TraceFormat::kOracleGeneral) return {path};
  return {path, trace_internal::companionOf(path)};
}

void refuseCompressed(const std::filesystem::path& path) {
  const std::filesystem::path plain = trace_internal::withoutPackedEnding(path);
  if (plain != path)
    fail("{}: compressed traces are read, not written; name it {} and compress it afterwards",
         path.string(), plain.filename().string());
}

std::unique_ptr<TraceWriter> makeTraceWriter(const std::filesystem::path& path, TraceFormat format,
                                             uint64_t page_bytes) {
  using namespace trace_internal;
  SLUICE_CHECK_LT(uint64_t{0}, page_bytes);
  refuseCompressed(path);
  switch (format) {
    case TraceFormat::kText:
      return makeTextWriter(path, page_bytes);
    case TraceFormat::kBinary:
      return makeBinaryWriter(path, page_bytes);
    case TraceFormat::kCsv:
      return makeCsvWriter(path, page_bytes);
    case TraceFormat::kOracleGeneral:
      return makeOracleGeneralWriter(path, page_bytes);
    case TraceFormat::kDin:
      break;
  }
  return makeDinWriter(path, page_bytes);
}

Trace readAll(TraceReader& reader) {
  Trace trace;
  trace.page_bytes = reader.pageBytes();
  trace.carries_clusters = reader.carriesClusters();
  TraceRecord record;
  while (reader.next(record)) trace.records.push_back(record);
  return trace;
}

}  // namespace sluice

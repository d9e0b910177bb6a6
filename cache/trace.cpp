#include "cache/trace.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <utility>

#include "cache/trace_formats.h"

namespace sluice {
namespace trace_internal {

const char* problemOf(const TraceRecord& record) {
  if (record.pages < 1 || record.pages > kMaxPages) return "pages from 1 to 2^31";
  const LoadBytes& b = record.bytes;
  if (b.moved > kMaxBytes) return "at most 2^40 bytes moved";
  if (b.needed > b.moved || b.extended > b.moved || b.empty > b.moved ||
      b.needed + b.extended + b.empty > b.moved)
    return "needed, extended and empty bytes within the bytes moved";
  return nullptr;
}

TraceRecord recordOfSize(uint64_t chunk, uint64_t bytes, uint64_t frame, uint64_t page_bytes) {
  TraceRecord record;
  record.chunk = chunk;
  record.frame = static_cast<uint32_t>(std::min<uint64_t>(frame, UINT32_MAX));
  const uint64_t pages = bytes / page_bytes + (bytes % page_bytes != 0 ? 1 : 0);
  record.pages = static_cast<uint32_t>(std::clamp<uint64_t>(pages, 1, UINT32_MAX));
  record.bytes.moved = record.pages * page_bytes;
  record.bytes.needed = bytes;
  return record;
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

std::optional<TraceFormat> guessFormat(std::istream& in, const std::filesystem::path& path) {
  std::array<char, 8> head{};
  in.read(head.data(), head.size());
  const std::string_view start(head.data(), static_cast<size_t>(in.gcount()));
  in.clear();
  in.seekg(0);
  if (start == trace_internal::kBinaryMagic) return TraceFormat::kBinary;
  if (trace_internal::kTextMagic.starts_with(start) && start.size() == head.size())
    return TraceFormat::kText;
  const std::string file = path.filename().string();
  if (file.ends_with(".csv")) return TraceFormat::kCsv;
  if (file.ends_with(".din")) return TraceFormat::kDin;
  if (file.find(".oracleGeneral") != std::string::npos || file.ends_with(".bin"))
    return TraceFormat::kOracleGeneral;
  return std::nullopt;
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

std::unique_ptr<TraceReader> makeTraceReader(std::unique_ptr<std::istream> in, std::string label,
                                             TraceFormat format, uint64_t page_bytes) {
  SLUICE_CHECK_LT(uint64_t{0}, page_bytes);
  switch (format) {
    case TraceFormat::kText:
      return trace_internal::makeTextReader(std::move(in), std::move(label));
    case TraceFormat::kBinary:
      return trace_internal::makeBinaryReader(std::move(in), std::move(label));
    default:
      return trace_internal::makeForeignReader(std::move(in), std::move(label), format, page_bytes);
  }
}

std::unique_ptr<TraceReader> openTrace(const std::filesystem::path& path,
                                       std::optional<TraceFormat> format, uint64_t page_bytes) {
  if (std::filesystem::is_directory(path))
    fail("{}: expected a trace file, found a folder", path.string());
  auto in = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*in) failErrno(fmt::format("{}: cannot open the trace", path.string()), errno);
  if (!format) format = guessFormat(*in, path);
  if (!format)
    fail(
        "{}: expected a trace (text, binary, .csv, .oracleGeneral or .din), found neither our "
        "first bytes nor a known extension; name the format",
        path.string());
  return makeTraceReader(std::move(in), path.string(), *format, page_bytes);
}

Trace readAll(TraceReader& reader) {
  Trace trace;
  trace.page_bytes = reader.pageBytes();
  TraceRecord record;
  while (reader.next(record)) trace.records.push_back(record);
  return trace;
}

}  // namespace sluice

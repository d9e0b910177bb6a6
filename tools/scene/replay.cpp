#include "tools/scene/replay.h"

#include <fmt/format.h>

#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// A trace does not tell how large the cache was that it was recorded with.
constexpr uint64_t kDefaultTracePages = 256;

class TraceFile final : public ReplaySource {
 public:
  TraceFile(std::string file, std::optional<TraceFormat> format, uint64_t page_bytes)
      : file_(std::move(file)), page_bytes_(page_bytes), format_(format) {}
  std::string title() const override { return file_; }
  uint64_t defaultPages() const override { return kDefaultTracePages; }
  std::optional<uint64_t> plannedPages(uint64_t /*pages*/) const override { return std::nullopt; }

  PreparedTrace requests(uint64_t /*pages*/) override {
    // Records are dropped as soon as they are prepared: a trace may be larger than memory.
    const auto reader = openTrace(file_, format_, page_bytes_);
    TracePreparer preparer(reader->pageBytes(), reader->carriesClusters());
    readInto(*reader, [&](const TraceRecord& record) { preparer.add(record); });
    PreparedTrace trace = preparer.finish();
    if (trace.resized > 0)
      warnings_.push_back(
          fmt::format("{}: {} of {} requests name another size than the first request of their "
                      "chunk; the first size counts",
                      file_, trace.resized, trace.keys.size()));
    return trace;
  }
  Trace records(uint64_t /*pages*/) override {
    Trace trace = readAll(*openTrace(file_, format_, page_bytes_));
    checkSome(trace.records.size());
    return trace;
  }
  uint64_t visit(uint64_t /*pages*/, const std::function<void(const TraceRecord&)>& take) override {
    const auto reader = openTrace(file_, format_, page_bytes_);
    readInto(*reader, take);
    return reader->pageBytes();
  }
  std::vector<std::string> warnings() const override { return warnings_; }

 private:
  template <class Take>
  void readInto(TraceReader& reader, const Take& take) {
    TraceRecord record;
    size_t count = 0;
    for (; reader.next(record); ++count) take(record);
    checkSome(count);
    // Each reading finds the same faults, so that they replace those of the one before.
    warnings_ = reader.warnings();
  }
  void checkSome(size_t count) const {
    if (count == 0) fail("{}: the trace is empty: it holds no requests", file_);
  }

  const std::string file_;
  const uint64_t page_bytes_;
  const std::optional<TraceFormat> format_;
  std::vector<std::string> warnings_;
};

}  // namespace

std::unique_ptr<ReplaySource> openTraceFile(const std::string& file,
                                            std::optional<TraceFormat> format,
                                            uint64_t page_bytes) {
  return std::make_unique<TraceFile>(file, format, page_bytes);
}

}  // namespace sluice

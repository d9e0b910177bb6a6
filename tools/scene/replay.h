// The input of `sluice simulate`: a recorded trace, which is the same at every cache size, or the
// requests of a turn around a volume (turn.h), planned for each size as the renderer would.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cache/trace/prepared_trace.h"
#include "src/library/opening/shown_channels.h"

namespace sluice {

// Sizes of caches are in pages as the user asks for them.
class ReplaySource {
 public:
  virtual ~ReplaySource() = default;
  // A title for people.
  virtual std::string title() const = 0;
  // The channel whose requests these are, if there are several; else null.
  virtual const ShownChannel* channel() const { return nullptr; }
  // The files that it is read from, but for those that the command names.
  virtual std::vector<std::string> files() const { return {}; }
  // The size to study if the user does not set one.
  virtual uint64_t defaultPages() const = 0;
  // The least size that can be planned for.
  virtual uint64_t leastPages() const { return 1; }
  // The pages that the cache really has if `pages` are asked for.
  virtual uint64_t cachePages(uint64_t pages) const { return pages; }
  // The cache size for which the chunks are planned that a cache of `pages` pages is asked for;
  // nullopt if that is not known. Requests for two sizes are the same if this is.
  virtual std::optional<uint64_t> plannedPages(uint64_t pages) const = 0;
  // The requests to a cache of `pages` pages. Throws Error: a damaged or empty file, a volume that
  // cannot be read, a cache too small to plan for.
  virtual PreparedTrace requests(uint64_t pages) = 0;
  // The same as records, which take some six times the memory.
  virtual Trace records(uint64_t pages) = 0;
  // The same one by one, from a trace without holding it in memory. Returns the bytes of a page.
  virtual uint64_t visit(uint64_t pages, const std::function<void(const TraceRecord&)>& take) = 0;
  // Notes for a person on the data read so far, a line each.
  virtual std::vector<std::string> warnings() const { return {}; }
  // Notes that were printed when it was opened, which belong into the report, too.
  virtual std::vector<std::string> openingNotes() const { return {}; }
};

// `format`: none if the file's name or first bytes tell. `page_bytes`: used if the format does not
// tell.
std::unique_ptr<ReplaySource> openTraceFile(const std::string& file,
                                            std::optional<TraceFormat> format, uint64_t page_bytes);

}  // namespace sluice

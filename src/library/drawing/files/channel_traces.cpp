#include "src/library/drawing/files/channel_traces.h"

#include <filesystem>
#include <system_error>

#include "cache/trace/trace.h"

namespace sluice {

std::vector<std::string> channelTraces(const std::string& path,
                                       const std::vector<const ShownChannel*>& channels) {
  const std::filesystem::path asked(path);
  refuseCompressed(asked);
  std::error_code none;
  // A device such as /dev/null takes all traces under its own name.
  if (channels.size() == 1 || std::filesystem::is_character_file(asked, none))
    return std::vector<std::string>(channels.size(), path);
  std::vector<std::string> paths;
  paths.reserve(channels.size());
  for (const ShownChannel* channel : channels)
    paths.push_back((asked.parent_path() /
                     (asked.stem().string() + "_" + channel->id() + asked.extension().string()))
                        .string());
  return paths;
}

}  // namespace sluice

// The files of traces of a picture that shows several channels.
#pragma once

#include <string>
#include <vector>

#include "src/library/opening/shown_channels.h"

namespace sluice {

// The trace of each of these channels if `path` is asked for: of a single channel the path itself,
// of several with the channel before the extension, "t_0.txt" and "t_over.txt" for "t.txt". A
// device such as /dev/null takes all of them. Throws Error, which names `path`, when its name
// promises a compressed file.
std::vector<std::string> channelTraces(const std::string& path,
                                       const std::vector<const ShownChannel*>& channels);

}  // namespace sluice

// The reads of a picture from a store of chunks, as the plan command prints them: requests and
// bytes of a server, and how often chunks are decoded.
#pragma once

#include <nlohmann/json.hpp>

#include <optional>
#include <string>

#include "src/library/drawing/cost/picture_cost.h"
#include "src/library/opening/pass_forecast.h"
#include "tools/options/arguments.h"

namespace sluice {

// The reads of all channels when a volume on a server is opened, before a picture can be planned;
// nullopt: nothing is read, or the volume is a file of this machine. Reads metadata alone. Throws
// Error.
std::optional<PassForecast> passOverServer(const VolumeArguments& volume, const LookArguments& look,
                                           const ResourceArguments& resources,
                                           const FrameOptions& frame);
// The picture shows level 0, for which all of it is read once.
void addFinestLevel(PassForecast& pass, const IndexedVolume& volume);
// A line for people about it.
std::string passLine(const VolumeArguments& volume, const PassForecast& pass);

// Adds `store` if the volume is a store of chunks: what a picture reads of it, and what the pass
// before it does, if there is one.
void addStoreJson(nlohmann::json& report, const Forecast& forecast,
                  const std::optional<PassForecast>& pass);
// `is_distant`: on a server.
void printStore(const StoredReads& reads, bool is_distant);

}  // namespace sluice

// The JSON that scripts read: the names are fixed by the interface. Pure functions.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "src/render/session.h"
#include "tools/scene.h"

namespace CLI {
class App;
}

namespace sluice {

struct RenderedFrame {
  FrameReport report;
  double write_seconds = 0;
};

// One frame's object of `frames`.
nlohmann::json frameJson(const RenderedFrame& frame);
// The counters of a level.
nlohmann::json countersJson(const CacheCounters& counters);
// `dims`, `voxel_type`, ..., as `info` prints them.
nlohmann::json volumeJson(const IndexedVolume& volume);
// The whole report of `render`: frames, blocks, levels, memory, GL.
nlohmann::json sceneJson(const Scene& scene, const std::vector<RenderedFrame>& frames);
// The options that were given or have defaults, long names without dashes.
nlohmann::json optionsJson(const CLI::App& app);

}  // namespace sluice

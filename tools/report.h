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
  std::string empty = {};  // why its picture shows nothing, if it does
};

// One frame's object of `frames`.
nlohmann::json frameJson(const RenderedFrame& frame);
// The counters of a level.
nlohmann::json countersJson(const CacheCounters& counters);
// `look`: what was chosen, as the options that give it again.
nlohmann::json lookJson(const ChosenLook& look);
// Levels that are drawn.
nlohmann::json cutJson(const CutSummary& cut);
// The same in one line for people.
std::string cutLine(const CutSummary& cut);
// Whether anything is drawn coarser than it is stored.
bool isCoarser(const VisibleBlocks& blocks);
// `dims`, `voxel_type`, ..., as `info` prints them.
nlohmann::json volumeJson(const IndexedVolume& volume);
// Where the volume's outer voxel centres lie in the world, as a box along its axes.
struct WorldBounds {
  Vec3d lo, hi;
};
WorldBounds worldBounds(const VolumeLayout& layout);
// What the voxels' axes mean: "RAS" (x to the right, y to the front, z up) and so on where the file
// says it and they follow the world's axes nearly enough; empty otherwise.
std::string axisLetters(const VolumeLayout& layout);
// What to try where the volume does not say what is up in the world; empty where it does.
std::string uprightHint(const VolumeLayout& layout);
// "ras", "lps", "picture-rows", "y-up" or "none".
std::string_view name(WorldFrame frame);

// The whole report of `render`: frames, blocks, levels, memory, GL.
nlohmann::json sceneJson(const Scene& scene, const std::vector<RenderedFrame>& frames);
// The options that were given or have defaults, long names without dashes.
nlohmann::json optionsJson(const CLI::App& app);

}  // namespace sluice

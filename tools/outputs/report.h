// The JSON that scripts read: the names are fixed by the interface. Pure functions.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "tools/scene/open_scene.h"

namespace CLI {
class App;
}

namespace sluice {

struct RenderedFrame {
  FrameReport report;
  double write_seconds = 0;
  std::string empty = {};               // why its picture shows nothing, if it does
  std::vector<LayerFrame> layers = {};  // channels, if it shows several
  std::string empty_layers = {};        // which of these show nothing, and why
};

// The object of a frame in `frames`.
nlohmann::json frameJson(const RenderedFrame& frame);
// The counters of a level.
nlohmann::json countersJson(const CacheCounters& counters);
// `look`: the chosen look, as the options that reproduce it.
nlohmann::json lookJson(const ChosenLook& look);
// `dims`, `voxel_type`, ..., as `info` prints them.
nlohmann::json volumeJson(const IndexedVolume& volume);
// A channel's number, or "over".
nlohmann::json idJson(const ShownChannel& channel);
// The box of the volume's outer voxel centres, along the world's axes.
struct WorldBounds {
  Vec3d lo, hi;
};
WorldBounds worldBounds(const VolumeLayout& layout);
// The meaning of the voxels' axes: "RAS" (x to the right, y to the front, z up) and so on, if the
// file tells it and they follow the world's axes nearly enough; empty otherwise.
std::string axisLetters(const VolumeLayout& layout);
// Advice if the volume does not tell which direction of the world is up; empty otherwise.
std::string uprightHint(const VolumeLayout& layout);
// "ras", "lps", "picture-rows", "y-up" or "none".
std::string_view name(WorldFrame frame);

// The whole report of `render`: frames, blocks, levels, memory, GL.
nlohmann::json sceneJson(const Scene& scene, const std::vector<RenderedFrame>& frames);
// The options that were given or have defaults, long names without dashes.
nlohmann::json optionsJson(const CLI::App& app);

}  // namespace sluice

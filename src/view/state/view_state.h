// ViewState: everything that a window shows of a volume, as a plain value. Changes are pure
// functions from one state to the next, so that undo goes back in a list of states.
#pragma once

#include <sluice/options.h>
#include <sluice/volume.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sluice {

struct ViewState {
  // Has eye, target and up once a volume is open (Renderer::placed()).
  ViewOptions view;
  LookOptions look;
  int64_t time = 0;
  std::optional<double> step_vox;  // unset: as PictureOptions has it
  PictureOptions::Quality quality = PictureOptions::Quality::kPlain;
  std::optional<double> jitter;
  PictureOptions::Lighting lighting;
  std::optional<PictureOptions::Box> crop;
  std::vector<PictureOptions::Plane> clip_planes;
  std::optional<std::array<float, 3>> background;  // unset: pictures that are saved keep alpha
  std::array<int64_t, 3> cross{0, 0, 0};           // voxel whose slices are shown
  bool shows_slices = false;

  friend bool operator==(const ViewState&, const ViewState&) = default;
};

// The volume as the user names it.
struct ViewedVolume {
  std::vector<std::string> paths;
  VolumeOptions options;
};
// All files and addresses that it is read from.
inline std::vector<std::string> namesOf(const ViewedVolume& volume) {
  std::vector<std::string> names = volume.paths;
  if (!volume.options.over.empty()) names.push_back(volume.options.over);
  return names;
}

inline PictureOptions pictureOf(const ViewState& state, int width, int height) {
  PictureOptions picture;
  picture.width = width;
  picture.height = height;
  picture.view = state.view;
  picture.time = state.time;
  picture.step_vox = state.step_vox;
  picture.quality = state.quality;
  picture.jitter = state.jitter;
  picture.lighting = state.lighting;
  picture.crop = state.crop;
  picture.clip_planes = state.clip_planes;
  return picture;
}

}  // namespace sluice

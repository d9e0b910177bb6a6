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

// The picture's size is the window's or the command's, and keeps its default here. So do a window's
// options of one picture (OptionPart::kPicture). `view` has eye, target and up once a volume is
// open (Renderer::placed()).
struct ViewState : PictureOptions {
  LookOptions look;
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

}  // namespace sluice

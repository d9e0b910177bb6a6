// CameraPath: a camera that moves between key frames.
//
// File: {"keys": [{"at": 0, "azimuth": 0, "elevation": 10, "zoom": 1}, {"at": 1, "azimuth": 180}]}
// `at` runs from 0 (first frame) to 1 (last frame), ascending. Every other field is optional and
// keeps the value of the key before it, of the command line for the first: azimuth, elevation,
// fov (degrees), zoom (factor), and eye, target, up (world, three numbers), the first two together.
// azimuth and elevation turn the view that the command line names. A path has angles or eyes, see
// requireOneForm(). Between keys everything is linear but zoom, which is geometric.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/threads/stop_token.h"
#include "src/render/camera/camera.h"

namespace sluice {

struct CameraKey {
  double at = 0;
  std::optional<double> azimuth_deg, elevation_deg, zoom, field_of_view_deg;
  std::optional<Vec3d> eye, target, up;
};

struct CameraPath {
  std::vector<CameraKey> keys;  // ascending by `at`, not empty
};

// Throws Error with the path, the field and the expected value.
CameraPath readCameraPath(const std::filesystem::path& path, const StopToken& stop = {});
CameraPath parseCameraPath(std::string_view json, const std::string& where);

// Eye and target take the place of angles, so a path moves by one or the other from its first key
// on. Throws Error, which begins with `where`, for keys of both kinds, for angles beside the eye of
// `start`, and for an eye that neither the first key nor `start` has.
void requireOneForm(const CameraPath& path, const Camera& start, const std::string& where);

// Whether some key has eye and target.
bool hasEyes(const CameraPath& path);

// The place on the path of frame `frame` of `frames`, from 0 to 1.
double placeOnPath(int64_t frame, int64_t frames);

// The camera of frame `frame` of `frames`. `start` gives the fields that no key has.
Camera cameraAt(const CameraPath& path, const Camera& start, int64_t frame, int64_t frames);

}  // namespace sluice

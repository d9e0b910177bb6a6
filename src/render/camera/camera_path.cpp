#include "src/render/camera/camera_path.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/files/text_file.h"
#include "src/base/looks/view_limits.h"

namespace sluice {
namespace {

using nlohmann::json;

// Every camera field filled in.
struct Pose {
  double azimuth_deg, elevation_deg, zoom, field_of_view_deg;
  std::optional<Camera::LookAt> look_at;
  std::optional<Vec3d> up;
};

std::optional<double> number(const json& key, const char* field, const std::string& where) {
  if (!key.contains(field)) return std::nullopt;
  if (!key[field].is_number()) fail("{}: \"{}\" should be a number", where, field);
  return key[field].get<double>();
}

std::optional<Vec3d> triple(const json& key, const char* field, const std::string& where) {
  if (!key.contains(field)) return std::nullopt;
  const json& list = key[field];
  bool good = list.is_array() && list.size() == 3;
  for (size_t i = 0; good && i < 3; ++i) good = list[i].is_number();
  if (!good) fail("{}: \"{}\" should be three numbers", where, field);
  return Vec3d{list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

CameraKey parseKey(const json& key, const std::string& where) {
  if (!key.is_object())
    fail("{}: should be an object such as {{\"at\": 0, \"azimuth\": 30}}", where);
  constexpr std::array<std::string_view, 8> kFields = {"at",  "azimuth", "elevation", "zoom",
                                                       "fov", "eye",     "target",    "up"};
  // Misspelt fields would otherwise be ignored without a word.
  for (const auto& [field, value] : key.items())
    if (std::find(kFields.begin(), kFields.end(), field) == kFields.end())
      fail("{}: \"{}\" is not known; at, azimuth, elevation, zoom, fov, eye, target, up are", where,
           printable(field));
  CameraKey result;
  const auto at = number(key, "at", where);
  if (!at || *at < 0 || *at > 1) fail("{}: \"at\" should be a number from 0 to 1", where);
  result.at = *at;
  result.azimuth_deg = number(key, "azimuth", where);
  result.elevation_deg = number(key, "elevation", where);
  result.zoom = number(key, "zoom", where);
  result.field_of_view_deg = number(key, "fov", where);
  if (result.zoom && !(*result.zoom >= kLeastZoom && *result.zoom <= kMostZoom))
    fail("{}: \"zoom\" should be from {} to {}, found {}", where, kLeastZoom, kMostZoom,
         *result.zoom);
  if (result.field_of_view_deg &&
      !(*result.field_of_view_deg >= kLeastFieldOfViewDeg && *result.field_of_view_deg < 180))
    fail("{}: \"fov\" should be at least {} and below 180 degrees, found {}", where,
         kLeastFieldOfViewDeg, *result.field_of_view_deg);
  result.eye = triple(key, "eye", where);
  result.target = triple(key, "target", where);
  result.up = triple(key, "up", where);
  if (result.eye.has_value() != result.target.has_value())
    fail("{}: \"eye\" and \"target\" should be given together", where);
  // Lengths must be finite too, since the square of a longer one overflows.
  const auto hasLength = [](Vec3d v) { return length(v) > 0 && std::isfinite(length(v)); };
  if (result.eye && !hasLength(*result.eye - *result.target))
    fail("{}: \"eye\" should be apart from \"target\"", where);
  if (result.up && !hasLength(*result.up))
    fail("{}: \"up\" should be a direction with a length", where);
  return result;
}

Pose poseAfter(const Pose& before, const CameraKey& key) {
  // A key gives only what changes.
  Pose pose = before;
  pose.azimuth_deg = key.azimuth_deg.value_or(before.azimuth_deg);
  pose.elevation_deg = key.elevation_deg.value_or(before.elevation_deg);
  pose.zoom = key.zoom.value_or(before.zoom);
  pose.field_of_view_deg = key.field_of_view_deg.value_or(before.field_of_view_deg);
  if (key.eye) pose.look_at = Camera::LookAt{*key.eye, *key.target};
  if (key.up) pose.up = key.up;
  return pose;
}

template <class T>
T mix(const T& a, const T& b, double share) {
  return a * (1 - share) + b * share;
}

Pose between(const Pose& a, const Pose& b, double share) {
  Pose pose = a;
  pose.azimuth_deg = mix(a.azimuth_deg, b.azimuth_deg, share);
  pose.elevation_deg = mix(a.elevation_deg, b.elevation_deg, share);
  pose.field_of_view_deg = mix(a.field_of_view_deg, b.field_of_view_deg, share);
  // Zoom is a ratio: equal parts of the way are equal factors.
  pose.zoom = a.zoom * std::pow(b.zoom / a.zoom, share);
  // Between two keys only if both have it: a camera that one key alone places cannot be halfway.
  if (a.look_at && b.look_at) {
    pose.look_at->eye = mix(a.look_at->eye, b.look_at->eye, share);
    pose.look_at->target = mix(a.look_at->target, b.look_at->target, share);
  }
  if (a.up && b.up) pose.up = mix(*a.up, *b.up, share);
  return pose;
}

}  // namespace

CameraPath parseCameraPath(std::string_view text, const std::string& where) {
  const json root = parseJson(text, where);
  if (!root.is_object() || !root.contains("keys") || !root["keys"].is_array() ||
      root["keys"].empty())
    fail("{}: should be {{\"keys\": [...]}} with at least one key", where);
  for (const auto& [field, value] : root.items())
    if (field != "keys") fail("{}: \"{}\" is not known; \"keys\" is", where, printable(field));
  CameraPath path;
  for (const json& key : root["keys"]) {
    const std::string place = fmt::format("{}: key {}", where, path.keys.size());
    path.keys.push_back(parseKey(key, place));
    if (path.keys.size() > 1 && path.keys.back().at <= path.keys[path.keys.size() - 2].at)
      fail("{}: \"at\" must be greater than the previous key's", place);
  }
  return path;
}

CameraPath readCameraPath(const std::filesystem::path& path, const StopToken& stop) {
  // No path is this long; a volume given by mistake is.
  constexpr uint64_t kMostBytes = uint64_t{16} << 20;
  return parseCameraPath(readTextFile(path, kMostBytes, "a camera path", stop), path.string());
}

bool hasEyes(const CameraPath& path) {
  return std::ranges::any_of(path.keys, [](const CameraKey& key) { return key.eye.has_value(); });
}

void requireOneForm(const CameraPath& path, const Camera& start, const std::string& where) {
  const auto angle = std::ranges::find_if(
      path.keys, [](const CameraKey& key) { return key.azimuth_deg || key.elevation_deg; });
  const auto eye =
      std::ranges::find_if(path.keys, [](const CameraKey& key) { return key.eye.has_value(); });
  const bool has_angle = angle != path.keys.end(), has_eye = eye != path.keys.end();
  const auto number = [&](auto key) { return key - path.keys.begin(); };
  if (has_angle && (has_eye || start.look_at))
    fail(
        "{}: key {}: \"{}\" has no effect beside \"eye\" and \"target\"{}; give angles or "
        "positions "
        "in all keys",
        where, number(angle), angle->azimuth_deg ? "azimuth" : "elevation",
        has_eye ? fmt::format(" of key {}", number(eye)) : ", which the path starts from");
  if (has_eye && eye != path.keys.begin() && !start.look_at)
    fail(
        "{}: key 0: expected \"eye\" and \"target\", which key {} has; without them, the camera "
        "would jump there",
        where, number(eye));
}

double placeOnPath(int64_t frame, int64_t frames) {
  // A single frame shows the beginning.
  return frames > 1 ? static_cast<double>(frame) / static_cast<double>(frames - 1) : 0;
}

Camera cameraAt(const CameraPath& path, const Camera& start, int64_t frame, int64_t frames) {
  const double at = placeOnPath(frame, frames);
  Pose pose{start.azimuth_deg,       start.elevation_deg, start.zoom,
            start.field_of_view_deg, start.look_at,       start.up};
  Pose before = poseAfter(pose, path.keys.front());
  double before_at = path.keys.front().at;
  pose = before;
  // Keys behind `at` have no part in it, so that the walk ends at the first of them.
  for (size_t i = 1; i < path.keys.size() && before_at < at; ++i) {
    const Pose after = poseAfter(before, path.keys[i]);
    const double after_at = path.keys[i].at;
    pose =
        at >= after_at ? after : between(before, after, (at - before_at) / (after_at - before_at));
    before = after;
    before_at = after_at;
  }
  Camera camera = start;
  camera.azimuth_deg = pose.azimuth_deg;
  camera.elevation_deg = pose.elevation_deg;
  camera.zoom = pose.zoom;
  camera.field_of_view_deg = pose.field_of_view_deg;
  camera.look_at = pose.look_at;
  camera.up = pose.up;
  return camera;
}

}  // namespace sluice

// Camera paths: parsing, hostile files, and interpolation.
#include "src/render/camera/camera_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "src/base/error.h"
#include "tests/support/temp_folder.h"

namespace sluice::camera_path_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string errorOf(const std::string& json) {
  try {
    parseCameraPath(json, "turn.json");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

CameraPath pathOf(const std::string& keys) {
  return parseCameraPath(R"({"keys": [)" + keys + "]}", "turn.json");
}

TEST(CameraPath, refusesCamerasThatCannotBe) {
  for (const char* camera :
       {R"("fov": 0)", R"("fov": 1e-320)", R"("zoom": 1e-320)", R"("fov": 180)", R"("fov": -1)",
        R"("zoom": 0)", R"("zoom": -1)", R"("eye": [1, 2, 3], "target": [1, 2, 3])",
        R"("eye": [1e300, 0, 0], "target": [0, 0, 0])", R"("up": [0, 0, 0])",
        R"("up": [1e300, 0, 0])"})
    EXPECT_THAT(errorOf(R"({"keys": [{"at": 0}, {"at": 1, )" + std::string(camera) + "}]}"),
                HasSubstr("turn.json: key 1: "))
        << camera;
}

TEST(CameraPath, keysHoldWhatTheySay) {
  const CameraPath path = pathOf(
      R"({"at": 0, "azimuth": 10, "zoom": 2},
         {"at": 0.5, "elevation": -20, "fov": 40},
         {"at": 1, "eye": [1, 2, 3], "target": [4, 5, 6], "up": [0, 0, 1]})");
  ASSERT_EQ(path.keys.size(), 3U);
  EXPECT_EQ(path.keys[0].azimuth_deg, 10);
  EXPECT_EQ(path.keys[0].zoom, 2);
  EXPECT_FALSE(path.keys[0].elevation_deg.has_value());
  EXPECT_EQ(path.keys[1].at, 0.5);
  EXPECT_EQ(path.keys[1].elevation_deg, -20);
  EXPECT_EQ(path.keys[1].field_of_view_deg, 40);
  EXPECT_EQ(path.keys[2].eye, (Vec3d{1, 2, 3}));
  EXPECT_EQ(path.keys[2].target, (Vec3d{4, 5, 6}));
  EXPECT_EQ(path.keys[2].up, (Vec3d{0, 0, 1}));
}

TEST(CameraPath, framesRunFromTheFirstKeyToTheLast) {
  const CameraPath path = pathOf(R"({"at": 0, "azimuth": 0}, {"at": 1, "azimuth": 180})");
  EXPECT_NEAR(cameraAt(path, {}, 0, 5).azimuth_deg, 0, 1e-12);
  EXPECT_NEAR(cameraAt(path, {}, 1, 5).azimuth_deg, 45, 1e-12);
  EXPECT_NEAR(cameraAt(path, {}, 4, 5).azimuth_deg, 180, 1e-12);
  EXPECT_NEAR(cameraAt(path, {}, 0, 1).azimuth_deg, 0, 1e-12) << "one frame is the first";
}

TEST(CameraPath, zoomIsGeometricAndTheRestLinear) {
  const CameraPath path = pathOf(
      R"({"at": 0, "zoom": 1, "elevation": 0, "fov": 20}, {"at": 1, "zoom": 4, "elevation": 60, "fov": 40})");
  const Camera camera = cameraAt(path, {}, 1, 3);
  EXPECT_NEAR(camera.zoom, 2, 1e-12);
  EXPECT_NEAR(camera.elevation_deg, 30, 1e-12);
  EXPECT_NEAR(camera.field_of_view_deg, 30, 1e-12);
}

TEST(CameraPath, fieldsKeepTheirValueUntilAKeyChangesThem) {
  Camera start;
  start.projection = Projection::kPerspective;
  start.elevation_deg = 12;
  start.zoom = 3;
  const CameraPath path =
      pathOf(R"({"at": 0.25, "azimuth": 40}, {"at": 0.5}, {"at": 0.75, "azimuth": 80})");
  EXPECT_EQ(cameraAt(path, start, 0, 5).azimuth_deg, 40) << "before the first key: the first key";
  EXPECT_EQ(cameraAt(path, start, 2, 5).azimuth_deg, 40);
  EXPECT_EQ(cameraAt(path, start, 4, 5).azimuth_deg, 80) << "after the last key: the last key";
  const Camera camera = cameraAt(path, start, 2, 5);
  EXPECT_EQ(camera.elevation_deg, 12);
  EXPECT_EQ(camera.zoom, 3);
  EXPECT_EQ(camera.projection, Projection::kPerspective);
}

TEST(CameraPath, eyeAndTargetMoveOnLines) {
  const CameraPath path = pathOf(
      R"({"at": 0, "eye": [0, 0, 10], "target": [0, 0, 0]}, {"at": 1, "eye": [4, 0, 6], "target": [0, 2, 0], "up": [1, 0, 0]})");
  Camera start;
  start.up = Vec3d{0, 1, 0};
  const Camera camera = cameraAt(path, start, 1, 3);
  ASSERT_TRUE(camera.look_at.has_value());
  EXPECT_EQ(camera.look_at->eye, (Vec3d{2, 0, 8}));
  EXPECT_EQ(camera.look_at->target, (Vec3d{0, 1, 0}));
  EXPECT_EQ(camera.up, (Vec3d{0.5, 0.5, 0}));
}

// Eye and target take the place of angles: one of both would be without effect, or a jump.
TEST(CameraPath, movesByAnglesOrByPositions) {
  const std::string eye = R"("eye": [0, 0, 10], "target": [0, 0, 0]})";
  const auto said = [](const std::string& keys, const Camera& start = {}) {
    try {
      requireOneForm(pathOf(keys), start, "turn.json");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(said(R"({"at": 0, )" + eye + R"(, {"at": 1, "azimuth": 90})"),
            "turn.json: key 1: \"azimuth\" has no effect beside \"eye\" and \"target\" of key 0; "
            "give angles or positions in all keys");
  EXPECT_THAT(said(R"({"at": 0, "elevation": 0}, {"at": 1, )" + eye),
              HasSubstr("turn.json: key 0: \"elevation\" has no effect beside \"eye\" and "
                        "\"target\" of key 1"));
  EXPECT_THAT(said(R"({"at": 0, "zoom": 2}, {"at": 1, )" + eye),
              HasSubstr("turn.json: key 0: expected \"eye\" and \"target\", which key 1 has"));
  EXPECT_EQ(said(R"({"at": 0, "zoom": 2, )" + eye + R"(, {"at": 1, "up": [1, 0, 0]})"), "");
  EXPECT_EQ(said(R"({"at": 0, "azimuth": 2}, {"at": 1, "elevation": 3})"), "");
  Camera start;
  start.look_at = Camera::LookAt{{0, 0, 5}, {0, 0, 0}};
  EXPECT_EQ(said(R"({"at": 0, "zoom": 2}, {"at": 1, )" + eye, start), "");
  EXPECT_THAT(said(R"({"at": 0}, {"at": 1, "azimuth": 90})", start),
              HasSubstr("turn.json: key 1: \"azimuth\" has no effect beside"));
}

TEST(CameraPath, readsAFile) {
  const TempFolder folder;
  writeFile(folder / "turn.json", R"({"keys": [{"at": 0, "azimuth": 7}]})");
  EXPECT_EQ(readCameraPath(folder / "turn.json").keys[0].azimuth_deg, 7);
  EXPECT_THROW(readCameraPath(folder / "none.json"), Error);
}

TEST(CameraPath, errorsNameTheFileTheKeyAndTheField) {
  EXPECT_THAT(
      errorOf(R"({"keys": [{"at": 0}, {"at": 1, "zoom": "big"}]})"),
      AllOf(HasSubstr("turn.json"), HasSubstr("key 1"), HasSubstr("zoom"), Not(HasSubstr("\n"))));
}

TEST(CameraPath, hostileFilesAreRefused) {
  const char* const bad[] = {"",
                             " ",
                             "{",
                             "[]",
                             "null",
                             "3",
                             "{}",
                             R"({"keys": {}})",
                             R"({"keys": []})",
                             R"({"keys": 5})",
                             R"({"keys": [1]})",
                             R"({"keys": [null]})",
                             R"({"keys": [[]]})",
                             R"({"keys": [{}]})",
                             R"({"keys": [{"at": "0"}]})",
                             R"({"keys": [{"at": null}]})",
                             R"({"keys": [{"at": -0.1}]})",
                             R"({"keys": [{"at": 1.1}]})",
                             R"({"keys": [{"at": 1e999}]})",
                             R"({"keys": [{"at": 0}, {"at": 0}]})",
                             R"({"keys": [{"at": 1}, {"at": 0}]})",
                             R"({"keys": [{"at": 0, "zoom": 0}]})",
                             R"({"keys": [{"at": 0, "zoom": -2}]})",
                             R"({"keys": [{"at": 0, "azimut": 2}]})",
                             R"({"keys": [{"at": 0, "azimuth": [1]}]})",
                             R"({"keys": [{"at": 0, "fov": true}]})",
                             R"({"keys": [{"at": 0, "eye": [1, 2, 3]}]})",
                             R"({"keys": [{"at": 0, "target": [1, 2, 3]}]})",
                             R"({"keys": [{"at": 0, "eye": [1, 2], "target": [1, 2, 3]}]})",
                             R"({"keys": [{"at": 0, "eye": [1, 2, "3"], "target": [1, 2, 3]}]})",
                             R"({"keys": [{"at": 0, "eye": "here", "target": [1, 2, 3]}]})",
                             R"({"keys": [{"at": 0}], "loop": true})",
                             R"({"keys": [{"at": 0, "at": 0.5}]} trailing)"};
  for (const char* json : bad) {
    const std::string error = errorOf(json);
    EXPECT_THAT(error, HasSubstr("turn.json")) << json;
    EXPECT_THAT(error, Not(HasSubstr("\n"))) << json;
  }
  EXPECT_NE(errorOf(std::string(200000, '[')), "") << "nested deeply";
  EXPECT_NE(errorOf(R"({"keys": )" + std::string(100000, '[') + std::string(100000, ']') + "}"),
            "");
}

}  // namespace
}  // namespace sluice::camera_path_test

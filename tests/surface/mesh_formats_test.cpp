// The file formats of meshes, against the mesh that a PLY has.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <sstream>

#include "tests/support/random_volume.h"
#include "tests/surface/made_surface.h"

namespace sluice::surface_test {
namespace {

TEST(MeshFormats, ofStlHasTheSameTriangles) {
  const auto source = makeWhiteNoise({40, 24, 21}, VoxelType::kU8, 4);
  const auto expected = sortedTriangles(make(*source, {.threshold = 60, .block = 8}).mesh);
  const Made made = make(*source, {.threshold = 60, .block = 8, .format = MeshFormat::kStl});
  uint32_t count = 0;
  std::memcpy(&count, made.bytes.data() + 80, sizeof count);
  ASSERT_EQ(made.bytes.size(), 84 + size_t{count} * 50);
  std::vector<std::array<Triple, 3>> triangles(count);
  for (size_t i = 0; i < count; ++i) {
    std::memcpy(triangles[i].data(), made.bytes.data() + 84 + i * 50 + 12, sizeof triangles[i]);
    auto& corners = triangles[i];
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  }
  std::ranges::sort(triangles);
  EXPECT_EQ(triangles, expected);
}

TEST(MeshFormats, ofObjHasTheSameVerticesAndTriangles) {
  const auto source = makeWhiteNoise({20, 14, 11}, VoxelType::kU16, 4);
  const Mesh expected = make(*source, {.threshold = 9000, .block = 8}).mesh;
  const Made made = make(*source, {.threshold = 9000, .block = 8, .format = MeshFormat::kObj});
  std::istringstream lines(made.bytes);
  std::string line;
  size_t vertices = 0, normals = 0, triangles = 0;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v" || word == "vn") {
      Triple triple;
      words >> triple[0] >> triple[1] >> triple[2];
      const MeshVertex& vertex = expected.vertices.at(word == "v" ? vertices++ : normals++);
      EXPECT_EQ(triple, word == "v" ? vertex.position : vertex.normal);
    } else if (word == "f") {
      for (const uint32_t number : expected.triangles.at(triangles)) {
        words >> word;
        EXPECT_EQ(word, fmt::format("{0}//{0}", number + 1));
      }
      ++triangles;
    }
  }
  EXPECT_EQ(vertices, expected.vertices.size());
  EXPECT_EQ(normals, vertices);
  EXPECT_EQ(triangles, expected.triangles.size());
}

}  // namespace
}  // namespace sluice::surface_test

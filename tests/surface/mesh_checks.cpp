#include "tests/surface/mesh_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <sstream>
#include <string>

#include "tests/support/temp_folder.h"

namespace sluice {

Mesh readPly(const std::filesystem::path& path) {
  const std::string bytes = readFile(path);
  std::istringstream lines(bytes);
  std::string line;
  size_t vertices = 0, triangles = 0;
  while (std::getline(lines, line) && line != "end_header") {
    if (line.starts_with("element vertex ")) vertices = std::stoul(line.substr(15));
    if (line.starts_with("element face ")) triangles = std::stoul(line.substr(13));
  }
  size_t at = static_cast<size_t>(lines.tellg());
  Mesh mesh;
  mesh.vertices.resize(vertices);
  EXPECT_EQ(bytes.size(), at + vertices * sizeof(MeshVertex) + triangles * 13);
  std::memcpy(mesh.vertices.data(), bytes.data() + at, vertices * sizeof(MeshVertex));
  at += vertices * sizeof(MeshVertex);
  for (size_t i = 0; i < triangles; ++i, at += 13) {
    EXPECT_EQ(bytes[at], 3);
    Numbers numbers;
    std::memcpy(numbers.data(), bytes.data() + at + 1, sizeof numbers);
    mesh.triangles.push_back(numbers);
  }
  return mesh;
}

std::vector<std::pair<uint32_t, uint32_t>> openSides(const Mesh& mesh) {
  std::set<std::pair<uint32_t, uint32_t>> sides;
  for (const Numbers& t : mesh.triangles)
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_LT(t[i], mesh.vertices.size());
      EXPECT_NE(t[i], t[(i + 1) % 3]);
      EXPECT_TRUE(sides.insert({t[i], t[(i + 1) % 3]}).second) << "a side of two triangles";
    }
  std::vector<std::pair<uint32_t, uint32_t>> open;
  for (const auto& [a, b] : sides)
    if (sides.count({b, a}) == 0) open.emplace_back(a, b);
  return open;
}

void expectVerticesOnce(const Mesh& mesh) {
  std::vector<bool> used(mesh.vertices.size());
  for (const Numbers& t : mesh.triangles)
    for (const uint32_t i : t) used[i] = true;
  EXPECT_EQ(std::ranges::count(used, false), 0);
  std::set<Triple> places;
  for (const MeshVertex& v : mesh.vertices) places.insert(v.position);
  EXPECT_EQ(places.size(), mesh.vertices.size());
}

std::vector<Triple> sortedPositions(const Mesh& mesh) {
  std::vector<Triple> places;
  for (const MeshVertex& v : mesh.vertices) places.push_back(v.position);
  std::ranges::sort(places);
  return places;
}

std::vector<std::array<Triple, 3>> sortedTriangles(const Mesh& mesh) {
  std::vector<std::array<Triple, 3>> triangles;
  for (const Numbers& t : mesh.triangles) {
    std::array<Triple, 3> corners{mesh.vertices[t[0]].position, mesh.vertices[t[1]].position,
                                  mesh.vertices[t[2]].position};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::ranges::sort(triangles);
  return triangles;
}

double enclosedVolume(const Mesh& mesh) {
  double sum = 0;
  for (const Numbers& t : mesh.triangles)
    sum += dot(mesh.position(t[0]), cross(mesh.position(t[1]), mesh.position(t[2]))) / 6;
  return sum;
}

}  // namespace sluice

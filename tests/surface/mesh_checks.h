// Meshes that were written, and what is always true of one that is right.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "io/meshes/mesh_file.h"
#include "src/base/values/vec.h"

namespace sluice {

using Triple = std::array<float, 3>;
using Numbers = std::array<uint32_t, 3>;

struct Mesh {
  std::vector<MeshVertex> vertices;
  std::vector<Numbers> triangles;

  Vec3d position(size_t i) const {
    const Triple& p = vertices[i].position;
    return {p[0], p[1], p[2]};
  }
  Vec3d normal(size_t i) const {
    const Triple& n = vertices[i].normal;
    return {n[0], n[1], n[2]};
  }
};

// A PLY of ours, read by its header.
Mesh readPly(const std::filesystem::path& path);

// The directed sides of triangles that have no partner in the opposite direction. Fails if a side
// occurs twice.
std::vector<std::pair<uint32_t, uint32_t>> openSides(const Mesh& mesh);
// Fails unless all vertices are used and no two are at one place.
void expectVerticesOnce(const Mesh& mesh);

std::vector<Triple> sortedPositions(const Mesh& mesh);
// Triangles as positions, each turned to begin with its least corner, sorted.
std::vector<std::array<Triple, 3>> sortedTriangles(const Mesh& mesh);
// Above 0 if the triangles face outwards.
double enclosedVolume(const Mesh& mesh);

}  // namespace sluice

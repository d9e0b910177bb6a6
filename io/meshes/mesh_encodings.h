// The formats of meshes, a row each; for mesh_file.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "io/meshes/mesh_file.h"

namespace sluice {

struct MeshEncoding {
  // As long whatever the numbers are, so that it can be written again. `title` has no line break.
  std::string (*header)(const std::string& title, uint64_t vertices, uint64_t triangles);
  // Null: vertices have no part of their own in the file.
  void (*vertices)(std::span<const MeshVertex> vertices, std::string& out);
  void (*triangles)(std::span<const MeshTriangle> triangles, std::string& out);
  uint64_t most_vertices, most_triangles;
  const char* name;
  FileKind kind;
};

// It lives as long as the program.
const MeshEncoding& encodingOf(MeshFormat format);

}  // namespace sluice

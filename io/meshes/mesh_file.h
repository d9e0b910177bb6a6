// MeshFile: a mesh of triangles as PLY, STL or OBJ, written part by part so that it may be larger
// than memory.
//
// PLY (binary) and OBJ list the vertices, with their normals, and then the triangles by the numbers
// of their vertices. STL (binary) repeats the positions in each triangle and has a normal for each
// triangle. Numbers count from 0 in the order in which vertices are appended.
//
// Triangles wait in a temporary file beside the output until the last vertex has been written. The
// output appears whole under its name or not at all (src/base/files/atomic_file.h). Encoding may
// happen on any thread; append() and commit() are called by one thread at a time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "src/base/files/atomic_file.h"
#include "src/base/files/file_kind.h"

namespace sluice {

enum class MeshFormat { kPly, kStl, kObj };

// By the end of the name, in any case; nullopt: another one.
std::optional<MeshFormat> meshFormat(const std::filesystem::path& path);
FileKind kindOf(MeshFormat format);

struct MeshVertex {
  std::array<float, 3> position{}, normal{};  // in the world
};

// A corner of a triangle; the vertex must outlive it.
struct MeshCorner {
  const MeshVertex* vertex = nullptr;
  uint64_t number = 0;
};
using MeshTriangle = std::array<MeshCorner, 3>;

// Encoded vertices and triangles, in the order of the file.
struct MeshPart {
  std::string vertices, triangles;
  uint64_t vertex_count = 0, triangle_count = 0;

  uint64_t bytes() const { return vertices.size() + triangles.size(); }
};

// How a format writes its parts; one row of a table a format.
struct MeshEncoding;

class MeshFile {
 public:
  // `title`: a line for people in the file's header. Throws Error if the file cannot be made; a
  // pipe cannot, because the header with the numbers of vertices and triangles is written last.
  MeshFile(const std::filesystem::path& path, MeshFormat format, std::string title);
  ~MeshFile();

  // Add to `part`, which is appended later.
  void encode(std::span<const MeshVertex> vertices, MeshPart& part) const;
  void encode(std::span<const MeshTriangle> triangles, MeshPart& part) const;

  // Throws Error: a full disk, or more vertices or triangles than the format can number.
  void append(const MeshPart& part);
  // Joins the parts, writes the header's numbers and gives the file its name. Throws Error.
  void commit();

  uint64_t vertices() const { return vertices_; }
  uint64_t triangles() const { return triangles_; }

 private:
  void expectNumbers() const;
  void writeHeader();

  const std::filesystem::path path_;
  const MeshEncoding& encoding_;
  const std::string title_;
  AtomicFile file_;
  std::optional<AtomicFile> waiting_;  // triangles, if vertices come before them
  uint64_t file_bytes_ = 0, waiting_bytes_ = 0;
  uint64_t vertices_ = 0, triangles_ = 0;
};

}  // namespace sluice

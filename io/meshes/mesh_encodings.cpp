#include "io/meshes/mesh_encodings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstring>
#include <limits>

namespace sluice {
namespace {

constexpr bool kIsLittle = std::endian::native == std::endian::little;

template <class T>
void appendRaw(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// PLY. The header says which byte order the numbers have: this machine's.

std::string plyHeader(const std::string& title, uint64_t vertices, uint64_t triangles) {
  const auto header = [&](size_t padding) {
    return fmt::format(
        "ply\n"
        "format binary_{}_endian 1.0\n"
        "comment {}\n"
        "comment {}{}\n"
        "element vertex {}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\n"
        "element face {}\n"
        "property list uchar int vertex_indices\n"
        "end_header\n",
        kIsLittle ? "little" : "big", softwareMark(), title, std::string(padding, ' '), vertices,
        triangles);
  };
  // Readers expect numbers without leading zeros, so the comment makes up for their digits: the
  // header is written again at the end and must have the same length.
  constexpr size_t kMostDigits = std::numeric_limits<uint64_t>::digits10 + 1;
  const size_t digits = std::to_string(vertices).size() + std::to_string(triangles).size();
  return header(2 * kMostDigits - digits);
}

void plyVertices(std::span<const MeshVertex> vertices, std::string& out) {
  static_assert(sizeof(MeshVertex) == 6 * sizeof(float));
  out.append(reinterpret_cast<const char*>(vertices.data()), vertices.size_bytes());
}

void plyTriangles(std::span<const MeshTriangle> triangles, std::string& out) {
  constexpr size_t kBytes = 1 + 3 * sizeof(uint32_t);
  const size_t begin = out.size();
  out.resize(begin + triangles.size() * kBytes);
  char* to = out.data() + begin;
  for (const MeshTriangle& triangle : triangles) {
    const std::array<uint32_t, 3> numbers{static_cast<uint32_t>(triangle[0].number),
                                          static_cast<uint32_t>(triangle[1].number),
                                          static_cast<uint32_t>(triangle[2].number)};
    *to = 3;
    std::memcpy(to + 1, numbers.data(), sizeof numbers);
    to += kBytes;
  }
}

// STL: 80 bytes for people, the number of triangles, and 50 bytes for each; little-endian.

void appendLittle(std::string& out, std::integral auto value) {
  for (size_t i = 0; i < sizeof value; ++i)
    out.push_back(static_cast<char>(static_cast<uint64_t>(value) >> (8 * i) & 0xff));
}

void appendLittle(std::string& out, const std::array<float, 3>& triple) {
  if constexpr (kIsLittle) {
    appendRaw(out, triple);
  } else {
    for (const float each : triple) appendLittle(out, std::bit_cast<uint32_t>(each));
  }
}

// A header that begins with "solid" would be taken for text, and one that ends in a zero cannot be
// text.
std::string stlHeader(const std::string& title, uint64_t /*vertices*/, uint64_t triangles) {
  constexpr size_t kBytes = 80;
  std::string header = softwareMark() + ": " + title;
  header.resize(kBytes - 1, '\0');
  header.push_back('\0');
  appendLittle(header, static_cast<uint32_t>(triangles));
  return header;
}

// The direction of the triangle's face; zeros, which readers replace, if it has none.
std::array<float, 3> faceNormal(const MeshTriangle& triangle) {
  const auto at = [&](size_t corner, size_t axis) {
    return static_cast<double>(triangle[corner].vertex->position[axis]);
  };
  std::array<double, 3> u{}, v{};
  for (size_t i = 0; i < 3; ++i) u[i] = at(1, i) - at(0, i), v[i] = at(2, i) - at(0, i);
  const std::array<double, 3> n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                u[0] * v[1] - u[1] * v[0]};
  const double size = std::hypot(n[0], n[1], n[2]);
  if (!(size > 0)) return {};
  return {static_cast<float>(n[0] / size), static_cast<float>(n[1] / size),
          static_cast<float>(n[2] / size)};
}

void stlTriangles(std::span<const MeshTriangle> triangles, std::string& out) {
  for (const MeshTriangle& triangle : triangles) {
    appendLittle(out, faceNormal(triangle));
    for (const MeshCorner& corner : triangle) appendLittle(out, corner.vertex->position);
    appendLittle(out, uint16_t{0});
  }
}

// OBJ: text, a vertex or a triangle a line; numbers count from 1.

std::string objHeader(const std::string& title, uint64_t /*vertices*/, uint64_t /*triangles*/) {
  return fmt::format("# {}\n# {}\n", softwareMark(), title);
}

// The shortest text that reads back as the same number.
void appendText(std::string& out, auto number) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number);
  out.append(text.data(), end.ptr);
}

void appendLine(std::string& out, const char* word, const std::array<float, 3>& triple) {
  out += word;
  for (const float each : triple) {
    out.push_back(' ');
    appendText(out, each);
  }
  out.push_back('\n');
}

void objVertices(std::span<const MeshVertex> vertices, std::string& out) {
  for (const MeshVertex& vertex : vertices) {
    appendLine(out, "v", vertex.position);
    appendLine(out, "vn", vertex.normal);
  }
}

void objTriangles(std::span<const MeshTriangle> triangles, std::string& out) {
  for (const MeshTriangle& triangle : triangles) {
    out.push_back('f');
    for (const MeshCorner& corner : triangle) {
      out.push_back(' ');
      appendText(out, corner.number + 1);
      out += "//";
      appendText(out, corner.number + 1);
    }
    out.push_back('\n');
  }
}

constexpr uint64_t kAny = std::numeric_limits<uint64_t>::max();
constexpr MeshEncoding kPly{plyHeader, plyVertices, plyTriangles,  0x7fffffff,
                            kAny,      "PLY",       FileKind::kPly};
constexpr MeshEncoding kStl{stlHeader,  nullptr, stlTriangles,  kAny,
                            0xffffffff, "STL",   FileKind::kStl};
constexpr MeshEncoding kObj{objHeader, objVertices, objTriangles,  kAny,
                            kAny,      "OBJ",       FileKind::kObj};

}  // namespace

const MeshEncoding& encodingOf(MeshFormat format) {
  switch (format) {
    case MeshFormat::kStl:
      return kStl;
    case MeshFormat::kObj:
      return kObj;
    case MeshFormat::kPly:
      break;
  }
  return kPly;
}

}  // namespace sluice

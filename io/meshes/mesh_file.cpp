#include "io/meshes/mesh_file.h"

#include <fcntl.h>

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "io/files/file_list.h"
#include "io/meshes/mesh_encodings.h"
#include "src/base/error.h"
#include "src/base/files/descriptor.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// Whether bytes may be written at any place of the file that will be there.
const fs::path& seekable(const fs::path& path) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  if (fs::is_fifo(status) || fs::is_socket(status))
    failRequest(
        "{}: is a pipe, but a mesh has its number of triangles at its beginning, which is written "
        "last; give the name of a file",
        path.string());
  return path;
}

// Beside the output, where there is room for it; a device has no room.
fs::path waitingName(const fs::path& path) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  const bool is_device = fs::exists(status) && !fs::is_regular_file(status);
  fs::path name = is_device ? fs::temp_directory_path() / path.filename() : path;
  name += ".triangles";
  return name;
}

std::string oneLine(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

}  // namespace

std::optional<MeshFormat> meshFormat(const fs::path& path) {
  const std::string extension = lowerExtension(path);
  if (extension == ".ply") return MeshFormat::kPly;
  if (extension == ".stl") return MeshFormat::kStl;
  if (extension == ".obj") return MeshFormat::kObj;
  return std::nullopt;
}

FileKind kindOf(MeshFormat format) {
  return encodingOf(format).kind;
}

MeshFile::MeshFile(const fs::path& path, MeshFormat format, std::string title)
    : path_(path),
      encoding_(encodingOf(format)),
      title_(oneLine(std::move(title))),
      file_(seekable(path)) {
  // PLY and OBJ have all vertices before the triangles, which come together: triangles wait in a
  // file.
  if (encoding_.vertices != nullptr) waiting_.emplace(waitingName(path));
  writeHeader();
}

MeshFile::~MeshFile() = default;

void MeshFile::writeHeader() {
  const std::string header = encoding_.header(title_, vertices_, triangles_);
  file_.writeAt(0, std::as_bytes(std::span(header)));
  file_bytes_ = std::max<uint64_t>(file_bytes_, header.size());
}

void MeshFile::encode(std::span<const MeshVertex> vertices, MeshPart& part) const {
  if (encoding_.vertices != nullptr) encoding_.vertices(vertices, part.vertices);
  part.vertex_count += vertices.size();
}

void MeshFile::encode(std::span<const MeshTriangle> triangles, MeshPart& part) const {
  encoding_.triangles(triangles, part.triangles);
  part.triangle_count += triangles.size();
}

void MeshFile::expectNumbers() const {
  const bool has_vertices = vertices_ <= encoding_.most_vertices;
  if (has_vertices && triangles_ <= encoding_.most_triangles) return;
  failRequest(
      "{}: more than {} {}, which is all that {} can count; write another format, a part (--crop) "
      "or a coarser level (--level)",
      path_.string(), has_vertices ? encoding_.most_triangles : encoding_.most_vertices,
      has_vertices ? "triangles" : "vertices", encoding_.name);
}

void MeshFile::append(const MeshPart& part) {
  vertices_ += part.vertex_count;
  triangles_ += part.triangle_count;
  expectNumbers();
  file_.writeAt(file_bytes_, std::as_bytes(std::span(part.vertices)));
  file_bytes_ += part.vertices.size();
  AtomicFile& to = waiting_ ? *waiting_ : file_;
  uint64_t& at = waiting_ ? waiting_bytes_ : file_bytes_;
  to.writeAt(at, std::as_bytes(std::span(part.triangles)));
  at += part.triangles.size();
}

void MeshFile::commit() {
  if (waiting_) {
    constexpr size_t kBytes = size_t{1} << 20;
    std::vector<std::byte> bytes(kBytes);
    const fs::path& name = waiting_->temporaryPath();
    const Descriptor in(open(name.c_str(), O_RDONLY | O_CLOEXEC));
    for (uint64_t left = waiting_bytes_; left > 0;) {
      const std::span some(bytes.data(), static_cast<size_t>(std::min<uint64_t>(left, kBytes)));
      if (!in || !readAll(in.get(), some))
        fail("{}: cannot be read again; was it removed?", name.string());
      file_.writeAt(file_bytes_, some);
      file_bytes_ += some.size();
      left -= some.size();
    }
    waiting_.reset();
  }
  writeHeader();
  file_.commit();
}

}  // namespace sluice

#include "io/dicom/dicom_folder.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "io/files/file.h"
#include "io/files/file_list.h"
#include "src/base/error.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

constexpr int kMostFolderDepth = 8;
constexpr size_t kMostFiles = 1'000'000;

bool startsAsDicom(File& file) {
  std::array<char, 132> head{};
  const size_t got = file.readSome(0, std::as_writable_bytes(std::span(head)));
  return looksLikeDicom({head.data(), got});
}

DicomHeader headerOf(File& file) {
  return readDicomHeader(
      {file.path(), file.sizeBytes(),
       [&](uint64_t at, std::span<std::byte> out) { return file.readSome(at, out); }});
}

// Folders in a folder, in natural order, without hidden ones.
std::vector<fs::path> subfolders(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> found;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code unknown;
    if (!it->path().filename().native().starts_with('.') && it->is_directory(unknown) &&
        // Links may lead in a circle.
        !it->is_symlink(unknown))
      found.push_back(it->path());
  }
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return naturalLess(a.native(), b.native()); });
  return found;
}

bool isPicture(const fs::path& file) {
  const std::string ending = lowerExtension(file);
  return ending == ".png" || ending == ".tif" || ending == ".tiff" || ending == ".jpg";
}

// Whether the regular file can be read and is DICOM; what cannot be read is not for now.
bool isDicomFile(const fs::path& path) {
  std::error_code unknown;
  if (!fs::is_regular_file(path, unknown)) return false;
  try {
    File file(path);
    return startsAsDicom(file);
  } catch (const Error&) {
    return false;
  }
}

// Looks at no more than `left` files.
bool hasDicom(const fs::path& folder, int depth, int& left) {
  bool has_pictures = false;
  for (const fs::path& file : listFolder(folder)) {
    // A folder of millions of other files is told apart by its first few.
    if (left-- <= 0) return false;
    if (isDicomFile(file)) return true;
    has_pictures = has_pictures || isPicture(file);
  }
  if (has_pictures || depth >= kMostFolderDepth) return false;
  for (const fs::path& inner : subfolders(folder)) {
    if (left <= 0) return false;
    if (hasDicom(inner, depth + 1, left)) return true;
  }
  return false;
}

void addFiles(const fs::path& folder, int depth, std::vector<fs::path>& files) {
  for (fs::path& file : listFolder(folder)) files.push_back(std::move(file));
  if (files.size() > kMostFiles)
    fail("{}: more than {} files, expected a folder of DICOM images", folder.string(), kMostFiles);
  if (depth >= kMostFolderDepth) return;
  for (const fs::path& inner : subfolders(folder)) addFiles(inner, depth + 1, files);
}

}  // namespace

bool isDicomFolder(const fs::path& folder) {
  int left = 32;
  return hasDicom(folder, 0, left);
}

std::vector<DicomHeader> readDicomHeaders(const fs::path& folder, const StopToken& stop) {
  std::vector<fs::path> files;
  addFiles(folder, 0, files);
  std::vector<DicomHeader> headers;
  size_t without_image = 0;
  for (const fs::path& path : files) {
    stop.throwIfStopped();
    if (!isDicomFile(path)) continue;
    File file(path);
    DicomHeader header = headerOf(file);
    // A folder may also hold DICOMDIR, reports and presentation states, which are no slices.
    if (header.refusal.empty() || header.has_pixels)
      headers.push_back(std::move(header));
    else
      ++without_image;
  }
  if (headers.empty())
    fail("{}: none of its {} DICOM files has an image, expected a series of slices",
         folder.string(), without_image);
  return headers;
}

std::vector<DicomHeader> readDicomHeaders(const std::vector<fs::path>& files,
                                          const StopToken& stop) {
  std::vector<DicomHeader> headers;
  for (const fs::path& path : files) {
    stop.throwIfStopped();
    File file(path);
    headers.push_back(headerOf(file));
    if (!headers.back().refusal.empty()) requireDicomPixels(headers.back());
  }
  return headers;
}

}  // namespace sluice

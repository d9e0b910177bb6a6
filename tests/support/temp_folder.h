// TempFolder: a folder of its own for a test, removed with all it holds at the end.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace sluice {

class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }
  // Writes a file into it; returns its path. Throws Error when it cannot be written.
  std::filesystem::path write(std::string_view name, std::string_view bytes) const;

 private:
  std::filesystem::path path_;
};

// The file's bytes. Throws Error when it cannot be read.
std::string readFile(const std::filesystem::path& path);
void writeFile(const std::filesystem::path& path, std::string_view bytes);
// Each file below a folder, by its path from there, with its bytes.
std::map<std::string, std::string> filesOf(const std::filesystem::path& folder);

}  // namespace sluice

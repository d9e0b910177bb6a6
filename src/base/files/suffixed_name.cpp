#include "src/base/files/suffixed_name.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "src/base/values/fnv1a.h"

namespace sluice {
namespace {

// Bytes of a name in the folder; the limit of most file systems if the folder does not tell.
size_t longestName(const std::filesystem::path& folder) {
  constexpr long kUsual = 255;
  const long told = pathconf(folder.empty() ? "." : folder.c_str(), _PC_NAME_MAX);
  return static_cast<size_t>(told > 0 ? told : kUsual);
}

bool continuesCharacter(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

}  // namespace

std::filesystem::path suffixedName(const std::filesystem::path& path, std::string_view suffix) {
  const std::string name = path.filename().string();
  const size_t longest = longestName(path.parent_path());
  if (name.size() + suffix.size() <= longest) return path.string() + std::string(suffix);
  // The checksum is the same in every run, so that an interrupted run finds its file again.
  const std::string end = fmt::format("~{:08x}{}", static_cast<uint32_t>(fnv1a(name)), suffix);
  size_t kept = longest > end.size() ? std::min(longest - end.size(), name.size()) : 0;
  while (kept > 0 && kept < name.size() && continuesCharacter(name[kept])) --kept;
  return path.parent_path() / (name.substr(0, kept) + end);
}

}  // namespace sluice

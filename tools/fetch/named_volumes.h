// The public volumes that `sluice fetch NAME` knows: plain data, the rows of datasets.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace sluice {

// A raw file of a collection.
struct NamedVolume {
  std::string_view name, what;
  std::array<int64_t, 3> dims = {};
  std::string_view type;         // "uint8"
  std::string_view spacing;      // as --spacing takes it
  std::string_view credit;       // as the collection states it; empty: not known
  std::string_view sha256 = {};  // empty: not published

  // The name that the collection gives it; sluice reads sizes and type from it.
  std::string file() const;
  std::string address() const;
  // The size of the whole file, which follows from dims and type.
  uint64_t bytes() const;
  // The licence, or what takes its place, in a line.
  std::string terms() const;
  // The options that `sluice render` needs beside the file's name; empty, or with a space in front.
  std::string options() const;
};

// All of them, in the order of their names.
std::span<const NamedVolume> namedVolumes();
// null: there is none of that name.
const NamedVolume* findVolume(std::string_view name);

}  // namespace sluice

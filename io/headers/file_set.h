// FileSet: the data files that a header names, as a list or as a printf pattern with numbers.
//
// A pattern is not written out: "f%d 1 1000000000 1" costs nothing until a file is asked for.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sluice {

struct FileSet {
  std::vector<std::string> names;  // a list; empty when there is a pattern
  std::string pattern;             // with one %d, %i, %u, %x or %X and optional 0 and width
  int64_t first = 0, last = 0, step = 1;

  // No files: the voxels follow the header in its own file.
  bool attached() const { return names.empty() && pattern.empty(); }
  // Requires, for a pattern: as parseFilePattern made it.
  int64_t count() const;
  // The name as written in the header. Requires: 0 <= index < count().
  std::string name(int64_t index) const;
};

// Made from a pattern and the words of its three numbers. Throws Error, which starts with `path`,
// when the pattern has no single number in it or the numbers make no finite count.
FileSet parseFilePattern(const std::string& path, std::string_view pattern, std::string_view first,
                         std::string_view last, std::string_view step);
// Appends a name of a list. Throws Error when it is empty or has control characters.
void addFileName(const std::string& path, std::string_view name, FileSet& files);

}  // namespace sluice

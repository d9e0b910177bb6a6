// The fields of a NRRD header as text, before anything is made of them. Plain data.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/error.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// The fields by name, lower case and without spaces, and the lines after "data file: LIST".
struct NrrdFields {
  std::string path;
  std::map<std::string, std::string_view> values;
  std::vector<std::string_view> listed_files;
  size_t header_bytes = 0;
  bool ended_by_blank_line = false;

  // `name`: lower case, without spaces.
  std::optional<std::string_view> find(std::string_view name) const {
    const auto found = values.find(std::string(name));
    if (found == values.end()) return std::nullopt;
    return found->second;
  }
  // The same. Throws Error: there is no such field.
  std::string_view demand(std::string_view name) const {
    const std::optional<std::string_view> value = find(name);
    if (!value) fail("{}: the NRRD header has no field '{}'", path, name);
    return *value;
  }
};

// Lower case, without spaces and tabs.
std::string withoutSpaces(std::string_view text);
// Whether "data file: LIST" says that the names of files follow, a line each.
bool listFollows(std::string_view data_file);

// Reads the header to its end. The fields refer to `text`. `path`: for messages. Throws Error when
// it is no NRRD header, or has a field twice.
NrrdFields readNrrdFields(std::string_view text, const std::string& path);

// Adds a note of the fields that the format does not have: a misspelt field must not pass in
// silence, since 'byte inf' for 'byte skip' moves all voxels.
void noteUnknownFields(const NrrdFields& fields, VolumeLayout& layout);

}  // namespace sluice

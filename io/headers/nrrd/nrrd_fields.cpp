#include "io/headers/nrrd/nrrd_fields.h"

#include <algorithm>
#include <array>

#include "io/headers/header_fields.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

void demandMagic(std::string_view line, const std::string& path) {
  if (line.size() != 8 || !line.starts_with("NRRD000") || line[7] < '1' || line[7] > '5')
    fail("{}: no NRRD file: it starts with {}, NRRD0001 to NRRD0005 expected", path,
         inQuotes(line));
}

// All fields of the format, without spaces (http://teem.sourceforge.net/nrrd/format.html); most are
// not needed here.
constexpr std::array<std::string_view, 31> kKnownFields = {"axismaxs",
                                                           "axismins",
                                                           "blocksize",
                                                           "byteskip",
                                                           "centerings",
                                                           "centers",
                                                           "content",
                                                           "datafile",
                                                           "dimension",
                                                           "encoding",
                                                           "endian",
                                                           "kinds",
                                                           "labels",
                                                           "lineskip",
                                                           "max",
                                                           "min",
                                                           "number",
                                                           "oldmax",
                                                           "oldmin",
                                                           "sampleunits",
                                                           "sizes",
                                                           "space",
                                                           "spacedimension",
                                                           "spacedirections",
                                                           "spaceorigin",
                                                           "spaceunits",
                                                           "spacings",
                                                           "thicknesses",
                                                           "type",
                                                           "units",
                                                           "measurementframe"};

}  // namespace

std::string withoutSpaces(std::string_view text) {
  std::string packed = lowercase(text);
  std::erase_if(packed, [](char c) { return c == ' ' || c == '\t'; });
  return packed;
}

bool listFollows(std::string_view data_file) {
  return data_file == "LIST" || data_file.starts_with("LIST ");
}

NrrdFields readNrrdFields(std::string_view text, const std::string& path) {
  NrrdFields fields;
  fields.path = path;
  LineReader lines(text);
  demandMagic(lines.next().value_or(""), path);
  while (const std::optional<std::string_view> line = lines.next()) {
    if (line->empty()) {
      fields.ended_by_blank_line = true;
      break;
    }
    const std::optional<std::string_view> data_file = fields.find("datafile");
    if (data_file && listFollows(*data_file)) {
      fields.listed_files.push_back(trimmed(*line));
      continue;
    }
    const size_t colon = line->find(':');
    const bool key_value = colon != std::string_view::npos && line->substr(colon, 2) == ":=";
    // Comments, and key/value pairs of programs ("key:=value"), are no fields.
    if (line->front() == '#' || key_value) continue;
    if (colon == std::string_view::npos)
      fail("{}: header line {} is no 'field: value'", path, inQuotes(*line));
    const std::string name = withoutSpaces(line->substr(0, colon));
    if (!fields.values.emplace(name, trimmed(line->substr(colon + 1))).second)
      fail("{}: the header has the field {} twice", path, inQuotes(name));
  }
  fields.header_bytes = lines.position();
  return fields;
}

void noteUnknownFields(const NrrdFields& fields, VolumeLayout& layout) {
  std::vector<std::string> unknown;
  for (const auto& [name, value] : fields.values)
    if (std::find(kKnownFields.begin(), kKnownFields.end(), name) == kKnownFields.end())
      unknown.push_back(name);
  if (!unknown.empty()) layout.notes.push_back(unknownFieldsNote(fields.path, unknown));
}

}  // namespace sluice

// The formats that volumes are read in: one row of a table for each, which tells how a file of the
// format is known and opened. A reader is added here and nowhere else.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/named_input.h"
#include "io/open_options.h"
#include "src/base/error.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

struct Format {
  // Options that other formats refuse.
  struct Takes {
    bool description = false;  // --dims, --type, --endian, --skip
    bool grid = false;
    bool channel = false;
  };

  std::string_view name = {};    // in a list of formats; empty: in none
  std::string_view plural = {};  // of its volumes, in messages about options
  Takes takes = {};
  std::vector<std::string_view> endings = {};  // of names, in lower case
  // Whether the content is this format's.
  bool (*holds)(const NamedInput& input, const OpenOptions& options) = nullptr;
  // Whether the name is, beside the endings, if no format holds the content.
  bool (*named)(const NamedInput& input, const OpenOptions& options) = nullptr;
  // Throws Error in one line: what is missing, damaged or not understood, and what was expected.
  std::unique_ptr<VolumeSource> (*open)(const NamedInput& input,
                                        const OpenOptions& options) = nullptr;
  // Several files as one volume; empty: they are time steps as far as this format knows.
  std::unique_ptr<VolumeSource> (*join)(const std::vector<std::string>& files,
                                        const OpenOptions& options) = nullptr;
};

// The table, in the order in which content and names are looked at.
std::span<const Format> formats();

// A file that is of none of the formats.
class UnknownFormat : public Error {
 public:
  using Error::Error;
};

// The format of what lies at a name. Throws UnknownFormat or, of a store, Error: none of them.
const Format& formatOf(const NamedInput& input, const OpenOptions& options);

// Throws Error if an option is given that the format does not take, or that makes no sense.
void requireTaken(const std::string& name, const Format& format, const OpenOptions& options);

// The endings of names of volumes, in lower case, each once: ".nrrd", ".nii.gz". ".zarr" is a
// folder. For dialogs that offer files to choose from.
std::vector<std::string> volumeEndings();

}  // namespace sluice

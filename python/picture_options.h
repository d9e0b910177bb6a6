// Keywords of open(), render() and save(): the options of `sluice render` of the same names, with
// "_" for "-", as the table of options describes them (src/options/option_table.h), and a few more
// that belong to a picture alone.
#pragma once

#include <pybind11/pybind11.h>
#include <sluice/options.h>

#include <array>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/options/view_state.h"

namespace sluice::python {

namespace py = pybind11;

struct AskedPicture {
  PictureOptions picture;
  LookOptions look;
  std::optional<std::array<float, 3>> background;
  std::set<std::string> given;  // givenOptions() of the keywords
};

// Throws TypeError for a keyword that is none, or a value of another kind than it takes, and
// ValueError for a value out of its range or a picture that does not fit the volume.
AskedPicture askedPicture(const py::kwargs& keywords, const VolumeInfo& volume);

// Sets the options that the table has of a volume, and passes over all other keywords. Throws as
// askedPicture() does.
void takeVolumeKeywords(const py::dict& keywords, VolumeOptions& options);

// The keywords of a picture: those of a picture alone, and then the table's, in its order.
std::vector<std::string> pictureKeywords();

// A keyword and the type of its values, in the words of __init__.pyi; empty: a keyword that the
// signatures there name by themselves.
using KeywordType = std::pair<std::string, std::string>;
std::vector<KeywordType> pictureKeywordTypes();
std::vector<KeywordType> volumeKeywordTypes();

}  // namespace sluice::python

// LabelTable: names, colours and opacities of labels, as segmentation programs write them.
//
// Two kinds of text files are read, a label a line, with `#` in front of comments:
// - ITK-SNAP's label descriptions: number, red, green, blue (0 to 255), opacity (0 to 1), two flags
//   of which the first says whether the label shows, and the name in quotation marks;
// - 3D Slicer's colour tables: number, name, red, green, blue, opacity (0 to 255). FreeSurfer's
//   tables have this form with an opacity of 0 for all, which is read as opaque.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/looks/label_look.h"
#include "src/base/threads/stop_token.h"
#include "src/base/values/value_counts.h"
#include "src/base/values/vec.h"
#include "src/classify/transfer/transfer_function.h"

namespace sluice {

struct LabelStyle {
  double label = 0;
  Vec3d rgb{1, 1, 1};
  double opacity = 1;  // of a voxel length
  std::string name = {};
  bool is_background = false;  // stands for nothing: a look of all labels is not for it
  friend bool operator==(const LabelStyle&, const LabelStyle&) = default;
};

// Labels that a table or a volume has at the most.
inline constexpr size_t kMostLabels = size_t{1} << 16;

// Entries of a table of labels at the most. Each label has one of its own if their numbers span
// fewer.
inline constexpr int kMostLabelEntries = 1 << 20;

// Ascending by label, each once. Throws Error: one line with the path, the line, what was expected
// and what was found; and Interrupted, while it waits for a pipe.
std::vector<LabelStyle> readLabelTable(const std::filesystem::path& path,
                                       const StopToken& stop = {});
// The same from text; `where` starts the errors.
std::vector<LabelStyle> parseLabelTable(std::string_view text, const std::string& where);

// The fault of a table that shows labels of another volume alone, for people; empty: it has none.
// `styles`: those of the volume's labels, of which `counts` tells how often each occurs.
std::string faultOfTable(const std::vector<LabelStyle>& table,
                         const std::vector<LabelStyle>& styles, const ValueCounts& counts);

// The styles with those of a table in their place; labels that it does not name do not show.
void applyTable(std::vector<LabelStyle>& styles, const std::vector<LabelStyle>& table);
// The styles with so much of their opacity: labels that do not show stay hidden.
void scaleOpacities(std::vector<LabelStyle>& styles, double factor);
// The styles with the looks in their place, one after another; a look of all labels leaves the
// background as it is. Throws Error for a colour that there is not.
void applyLooks(std::vector<LabelStyle>& styles, const std::vector<LabelLook>& looks);

// Labels of these values, opaque and each with a colour of its number, or from `map` over all of
// them if one is named; `background` does not show. Throws Error if the map is unknown.
std::vector<LabelStyle> labelStyles(const std::vector<double>& values, double background,
                                    std::string_view map = {});

// How many labels are so close to another one, for the range of all of them, that a table of
// kMostLabelEntries may give both the same look. Requires: ascending.
size_t labelsTooClose(const std::vector<LabelStyle>& styles);

// The labels, each with its own look and nothing between them. Requires: ascending, not empty.
TransferFunction labelsTransfer(const std::vector<LabelStyle>& styles);

}  // namespace sluice

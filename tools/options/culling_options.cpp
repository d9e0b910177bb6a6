#include "tools/options/shared_options.h"

namespace sluice {

void addCullingOptions(CLI::App& app, CullingArguments& arguments, bool chooses) {
  const OptionGroup group = OptionGroup(app, kSeriesHeading).rare();
  if (chooses)
    group.choice("--culling",
                 Words<Culling>{{"none", Culling::kNone},
                                {"pof", Culling::kPof},
                                {"opof", Culling::kOpof},
                                {"toc", Culling::kToc},
                                {"auto", Culling::kAuto}},
                 arguments.culling,
                 "Skips blocks that others hide: by least opacities (pof), by ratios to thickness "
                 "(opof), or as opof, but estimates again only where blocks change (toc); auto: "
                 "toc if the series is prepared and its first steps are drawn faster with it");
  group.number(
      "--difference", "D", arguments.difference, {0, 1},
      "Fuses blocks of successive steps whose opacities differ less than this: the mean of "
      "the squared differences over the voxels that are not empty, 0 to 1; 0: none");
  group.number(
      "--directions", "N", arguments.directions, {1, 16},
      "Rows of directions, over 90 degrees, for which an opacity function keeps opacities");
  group.number("--part", "CELLS", arguments.part, {4, 64},
               "Cells per side of a part of a block in its opacity function, a multiple of 4");
  group.number(
      "--detail", "BITS", arguments.detail, {0, 2},
      "Bits for each of the 64 cubes of a part, 0 to 2; more bits cull more blocks and need more "
      "storage");
  group.text("--basis", "FILE,...", arguments.basis,
             "Computes opacity functions for these transfer functions; any other with opacity 1 - "
             "product of (1 - A)^K needs none of its own");
}

}  // namespace sluice

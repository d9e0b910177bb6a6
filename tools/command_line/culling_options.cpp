#include "tools/command_line/shared_options.h"

namespace sluice {

void addCullingOptions(CLI::App& app, CullingArguments& arguments, bool chooses) {
  const OptionGroup group(app, kSeriesHeading);
  if (chooses)
    group.choice("--culling",
                 Words<Culling>{{"none", Culling::kNone},
                                {"pof", Culling::kPof},
                                {"opof", Culling::kOpof},
                                {"toc", Culling::kToc},
                                {"auto", Culling::kAuto}},
                 arguments.culling,
                 "Leaves blocks unread that others hide: by least opacities (pof), by ratios to "
                 "thickness (opof), looking only at what changes (toc); auto: toc if the series is "
                 "prepared and its first steps are drawn faster with it");
  group.number("--difference", "D", arguments.difference, {0, 1},
               "Blocks of a series that differ less are fused; 0: none");
  group.number("--directions", "N", arguments.directions, {1, 16},
               "Rows of the table of directions over 90 degrees");
  group.number("--part", "CELLS", arguments.part, {4, 64},
               "Cells a side of a block's parts in its opacity function, a multiple of 4");
  group.number("--detail", "BITS", arguments.detail, {0, 2},
               "Bits of each of a part's 64 cubes: more are tighter and take more storage");
  group.text("--basis", "FILE,...", arguments.basis,
             "Transfer functions of which looks are members, 1 - product of (1 - A)^K: functions "
             "are made for these, and other looks of the family need none");
}

}  // namespace sluice

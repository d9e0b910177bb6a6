#include "tools/outputs/cut_report.h"

#include <fmt/format.h>

namespace sluice {

using nlohmann::json;

const char* wordOf(LevelValues values) {
  switch (values) {
    case LevelValues::kMeans:
      return "means";
    case LevelValues::kMaxima:
      return "maxima";
    case LevelValues::kMinima:
      return "minima";
    case LevelValues::kModes:
      return "modes";
    case LevelValues::kUnknown:
      break;
  }
  return "unknown";
}

namespace {

// The levels that a picture is drawn from, for people.
std::string originText(const CutSummary& cut) {
  switch (cut.values) {
    case LevelValues::kMaxima:
      return "from the largest values below each voxel";
    case LevelValues::kMinima:
      return "from the least values below each voxel";
    case LevelValues::kModes:
      return cut.has_spreads ? "from the most frequent labels below each voxel and their shares"
                             : "from the most frequent labels below each voxel";
    case LevelValues::kMeans:
    case LevelValues::kUnknown:
      break;
  }
  return cut.has_spreads ? "from means and spreads" : "from coarse voxels without a spread";
}

}  // namespace

json cutJson(const CutSummary& cut) {
  json levels = json::array();
  for (const CutSummary::Level& level : cut.levels)
    levels.push_back({{"level", level.level}, {"blocks", level.blocks}, {"cells", level.cells}});
  json summary{{"levels", levels},
               {"coarse_share", cut.coarse_share},
               {"values", wordOf(cut.values)},
               {"spreads", cut.has_spreads},
               {"thin_blocks", cut.thin_blocks},
               {"final", cut.is_final}};
  if (cut.spread)
    summary["spread"] = {{"largest", cut.spread->largest}, {"mean", cut.spread->mean}};
  return summary;
}

std::string cutLine(const CutSummary& cut) {
  std::string levels;
  for (const CutSummary::Level& level : cut.levels)
    levels += fmt::format("{}{} ({} block{})", levels.empty() ? "" : ", ", level.level,
                          level.blocks, level.blocks == 1 ? "" : "s");
  std::string line =
      cut.levels.empty()
          ? std::string("nothing that was read shows anything")
          : fmt::format(
                "{:.1f} % of what shows is drawn coarser than it is stored, at level {}, {}",
                100 * cut.coarse_share, levels, originText(cut));
  // The spread of labels is the share of voxels with other labels, not a distance of values.
  if (cut.spread && cut.values == LevelValues::kModes)
    line += fmt::format("; up to {:.0f} % of a voxel has other labels, {:.1f} % on average",
                        100 * cut.spread->largest, 100 * cut.spread->mean);
  else if (cut.spread)
    line +=
        fmt::format(" of up to {:.4g}, {:.3g} on average", cut.spread->largest, cut.spread->mean);
  if (cut.thin_blocks > 0)
    line += fmt::format("; {} block{} parts thinner than two voxels, --keep-thin refines {}",
                        cut.thin_blocks, cut.thin_blocks == 1 ? " has" : "s have",
                        cut.thin_blocks == 1 ? "it" : "them");
  // A user who sees a coarse picture wants to know which limit to raise.
  if (!cut.is_final) line += "; --memory, --max-bytes or --time-limit ended the refinement";
  return line;
}

std::string refinedLine(const CutSummary& cut) {
  std::string levels;
  for (const CutSummary::Level& level : cut.levels)
    levels += fmt::format("{}{}", levels.empty() ? "" : ", ", level.level);
  const char* const end = cut.is_final ? "final" : "will improve";
  if (cut.levels.empty()) return fmt::format("no level shows anything, {}", end);
  return fmt::format("level{} {}, {}", cut.levels.size() == 1 ? "" : "s", levels, end);
}

json refinedJson(const std::vector<RefinedPicture>& pictures) {
  json rows = json::array();
  for (const RefinedPicture& picture : pictures) {
    rows.push_back({{"seconds", picture.seconds}, {"step", picture.step_vox}});
    if (picture.cut) rows.back()["cut"] = cutJson(*picture.cut);
  }
  return rows;
}

bool isCoarser(const VisibleBlocks& blocks) {
  return blocks.cut && blocks.cut->coarse_share > 0;
}

}  // namespace sluice

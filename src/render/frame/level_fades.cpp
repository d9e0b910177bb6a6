#include "src/render/frame/level_fades.h"

#include <algorithm>
#include <ranges>
#include <utility>

namespace sluice {
namespace {

// The share that a seam leaves to the finer block: 0 at its face, 1 at the other end of its cells.
// `is_rest`: the other share.
void setRamp(const LevelSeam& seam, bool is_rest, LevelFade& fade) {
  const int axis = seam.face % 3;
  const double lo = static_cast<double>(seam.cells.lo[axis]);
  const double hi = static_cast<double>(seam.cells.hi[axis]);
  const bool rises = (seam.face < 3) != is_rest;
  const auto i = static_cast<size_t>(seam.face);
  fade.slope[i] = (rises ? 1 : -1) / (hi - lo);
  fade.start[i] = -(rises ? lo : hi) * fade.slope[i];
}

// A plane at which the cells of a seam begin or end within a box.
struct Cut {
  int axis;
  int64_t plane;
};
std::optional<Cut> cutBetween(const Box3& cells, std::span<const Box3> seams) {
  for (const Box3& seam : seams) {
    if (intersect(seam, cells).empty()) continue;
    for (int a = 0; a < 3; ++a)
      for (const int64_t plane : {seam.lo[a], seam.hi[a]})
        if (plane > cells.lo[a] && plane < cells.hi[a]) return Cut{a, plane};
  }
  return std::nullopt;
}

void addParts(const Box3& cells, std::span<const Box3> seams, const EyePosition& eye,
              std::vector<SeamPart>& parts) {
  if (const std::optional<Cut> cut = cutBetween(cells, seams)) {
    Box3 first = cells, last = cells;
    first.hi[cut->axis] = last.lo[cut->axis] = cut->plane;
    if (!passesLowerFirst(eye, cut->axis, cut->plane)) std::swap(first, last);
    addParts(first, seams, eye, parts);
    addParts(last, seams, eye, parts);
    return;
  }
  SeamPart part{cells, {}};
  for (size_t i = 0; i < seams.size(); ++i)
    if (!intersect(seams[i], cells).empty()) part.seams.push_back(i);
  parts.push_back(std::move(part));
}

}  // namespace

std::span<const LevelSeam> LevelFades::seamsOf(const BlockName& fine) const {
  const auto first = std::ranges::lower_bound(seams_, fine, {}, &LevelSeam::fine);
  return {first, std::ranges::upper_bound(first, seams_.end(), fine, {}, &LevelSeam::fine)};
}

std::optional<LevelFade> LevelFades::within(const BlockName& block) const {
  const std::span<const LevelSeam> seams = seamsOf(block);
  if (seams.empty()) return std::nullopt;
  LevelFade fade;
  for (const LevelSeam& seam : seams) setRamp(seam, false, fade);
  return fade;
}

LevelFade LevelFades::rest(const LevelSeam& seam) const {
  LevelFade fade;
  for (const LevelSeam& other : seamsOf(seam.fine))
    if (other.face < seam.face) setRamp(other, false, fade);
  setRamp(seam, true, fade);
  return fade;
}

SeamBoxes seamBoxes(const LevelSeam& seam, BoxDraw coarse, const Box3& fine, const Box3& shown,
                    const EyePosition& eye) {
  SeamBoxes boxes;
  const Box3 cells = intersect(seam.cells, shown);
  coarse.beside = fine;
  coarse.cells = intersect(cells, fine);
  if (!coarse.cells.empty()) {
    boxes.joined = coarse;
    boxes.joined->joins = true;
  }
  // The finer block may be trimmed and end before its face.
  const int axis = seam.face % 3;
  const bool is_upper = seam.face >= 3;
  coarse.cells = cells;
  if (is_upper)
    coarse.cells.lo[axis] = std::max(cells.lo[axis], fine.hi[axis]);
  else
    coarse.cells.hi[axis] = std::min(cells.hi[axis], fine.lo[axis]);
  if (coarse.cells.empty()) return boxes;
  boxes.beyond = coarse;
  const int64_t plane = is_upper ? coarse.cells.lo[axis] : coarse.cells.hi[axis];
  boxes.is_before = passesLowerFirst(eye, axis, plane) != is_upper;
  return boxes;
}

std::vector<SeamPart> partsAtSeams(const Box3& cells, std::span<const Box3> seams,
                                   const EyePosition& eye) {
  std::vector<SeamPart> parts;
  addParts(cells, seams, eye, parts);
  return parts;
}

}  // namespace sluice

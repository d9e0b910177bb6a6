#include "src/render/frame/level_fades.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <ranges>
#include <utility>

namespace sluice {
namespace {

// The share that a seam leaves to the finer block: 0 at its face, 1 at the other end of its cells.
// `is_rest`: the other share.
void setRamp(const LevelSeam& seam, bool is_rest, LevelFade& fade) {
  const int face = std::countr_zero(seam.faces), axis = face % 3;
  const double lo = static_cast<double>(seam.cells.lo[axis]);
  const double hi = static_cast<double>(seam.cells.hi[axis]);
  const bool rises = (face < 3) != is_rest;
  const auto i = static_cast<size_t>(face);
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

LevelFades::LevelFades(std::span<const LevelSeam> seams)
    : seams_(seams), by_coarser_(seams.size()) {
  std::iota(by_coarser_.begin(), by_coarser_.end(), 0U);
  std::ranges::stable_sort(by_coarser_, {}, [&](uint32_t i) { return seams_[i].coarse; });
}

std::span<const LevelSeam> LevelFades::seamsOf(const BlockName& fine) const {
  const auto first = std::ranges::lower_bound(seams_, fine, {}, &LevelSeam::fine);
  return {first, std::ranges::upper_bound(first, seams_.end(), fine, {}, &LevelSeam::fine)};
}

std::optional<LevelFade> LevelFades::within(const BlockName& block) const {
  std::optional<LevelFade> fade;
  for (const LevelSeam& seam : seamsOf(block)) {
    if (!seam.isFace()) break;
    if (!fade) fade.emplace();
    setRamp(seam, false, *fade);
  }
  return fade;
}

LevelFade LevelFades::rest(const LevelSeam& seam) const {
  LevelFade fade;
  if (!seam.isFace()) {
    fade.start.fill(0);
    return fade;
  }
  for (const LevelSeam& other : seamsOf(seam.fine)) {
    if (other.faces == seam.faces) break;
    setRamp(other, false, fade);
  }
  setRamp(seam, true, fade);
  return fade;
}

bool LevelFades::hasSeamAt(const BlockName& fine, int face) const {
  return std::ranges::any_of(seamsOf(fine),
                             [face](const LevelSeam& seam) { return seam.faces == 1U << face; });
}

std::vector<Box3> LevelFades::cellsInFiner(const BlockName& coarse) const {
  const auto coarseOf = [this](uint32_t i) { return seams_[i].coarse; };
  const auto first = std::ranges::lower_bound(by_coarser_, coarse, {}, coarseOf);
  std::vector<Box3> cells;
  for (auto i = first; i != by_coarser_.end() && coarseOf(*i) == coarse; ++i)
    cells.push_back(seams_[*i].cells);
  return cells;
}

bool passesLowerFirst(const EyePosition& eye, int axis, int64_t plane) {
  return eye.parallel ? eye.index[axis] >= 0 : eye.index[axis] < static_cast<double>(plane);
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
  // The finer block may be trimmed and end before its faces.
  Box3 rest = cells;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_upper : {false, true}) {
      const int64_t plane =
          std::clamp(is_upper ? fine.hi[axis] : fine.lo[axis], rest.lo[axis], rest.hi[axis]);
      coarse.cells = rest;
      (is_upper ? coarse.cells.lo : coarse.cells.hi)[axis] = plane;
      (is_upper ? rest.hi : rest.lo)[axis] = plane;
      if (coarse.cells.empty()) continue;
      const bool is_before = passesLowerFirst(eye, axis, plane) != is_upper;
      // Each part lies outside of those that are cut off after it.
      if (is_before)
        boxes.before.push_back(coarse);
      else
        boxes.behind.insert(boxes.behind.begin(), coarse);
    }
  return boxes;
}

std::vector<SeamPart> partsAtSeams(const Box3& cells, std::span<const Box3> seams,
                                   const EyePosition& eye) {
  std::vector<SeamPart> parts;
  addParts(cells, seams, eye, parts);
  return parts;
}

}  // namespace sluice

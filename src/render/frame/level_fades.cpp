#include "src/render/frame/level_fades.h"

#include <algorithm>
#include <ranges>

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

}  // namespace

LevelFades::LevelFades(std::span<const LevelSeam> seams) : seams_(seams) {
  for (size_t i = 0; i < seams.size(); ++i) of_coarse_[seams[i].coarse].push_back(i);
}

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

void LevelFades::addBorders(const BlockName& block, const BoxDraw& box, const Box3& shown,
                            const EyePosition& eye, LevelBorders& borders) const {
  const auto found = of_coarse_.find(block);
  if (found == of_coarse_.end()) return;
  for (const size_t i : found->second) {
    const LevelSeam& seam = seams_[i];
    BoxDraw border = box;
    border.cells = intersect(seam.cells, shown);
    if (border.cells.empty()) continue;
    border.beside = box.cells;
    LevelFade fade;
    for (const LevelSeam& other : seamsOf(seam.fine))
      if (other.face < seam.face) setRamp(other, false, fade);
    setRamp(seam, true, fade);
    border.fade = fade;
    const int axis = seam.face % 3;
    const bool lies_below = seam.face >= 3;  // than the coarser block
    const int64_t plane = lies_below ? seam.cells.hi[axis] : seam.cells.lo[axis];
    const bool is_before = passesLowerFirst(eye, axis, plane) == lies_below;
    (is_before ? borders.before : borders.behind).push_back(border);
  }
}

}  // namespace sluice

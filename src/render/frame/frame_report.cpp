#include "src/render/frame/frame_report.h"

#include <algorithm>

namespace sluice {
namespace {

void add(StageSeconds& sum, const StageSeconds& more) {
  sum.classify += more.classify;
  sum.plan += more.plan;
  sum.read += more.read;
  sum.decode += more.decode;
  sum.copy += more.copy;
  sum.upload += more.upload;
  sum.draw += more.draw;
  sum.boxes += more.boxes;
  sum.light += more.light;
}

void add(OcclusionReport& sum, const OcclusionReport& more) {
  sum.updates_wanted += more.updates_wanted;
  sum.updates += more.updates;
  sum.cells += more.cells;
  sum.cells_culled += more.cells_culled;
  sum.cells_clipped += more.cells_clipped;
  sum.chunks_hidden += more.chunks_hidden;
  sum.seconds += more.seconds;
}

}  // namespace

MovedBytes& MovedBytes::operator+=(const MovedBytes& more) {
  decoded += more.decoded;
  copied += more.copied;
  uploaded += more.uploaded;
  return *this;
}

BlockClasses& BlockClasses::operator+=(const BlockClasses& more) {
  white += more.white;
  grey += more.grey;
  black += more.black;
  return *this;
}

void addStrip(FrameReport& sum, const FrameReport& more) {
  sum.seconds += more.seconds;
  add(sum.stages, more.stages);
  sum.samples_drawn += more.samples_drawn;
  sum.samples_taken += more.samples_taken;
  sum.samples_object += more.samples_object;
  sum.boxes_drawn += more.boxes_drawn;
  sum.pages_loaded += more.pages_loaded;
  sum.binds += more.binds;
  sum.decoded_bytes += more.decoded_bytes;
  sum.copied_bytes += more.copied_bytes;
  sum.uploaded_bytes += more.uploaded_bytes;
  sum.missing_share = std::max(sum.missing_share, more.missing_share);
  add(sum.occlusion, more.occlusion);
  sum.cut = more.cut;  // the last strip knows the spreads of all blocks
}

void addLayer(FrameReport& sum, const FrameReport& layer) {
  std::optional<CutSummary> cut = sum.cut;
  addStrip(sum, layer);
  sum.step_vox = std::min(sum.step_vox, layer.step_vox);
  sum.blocks += layer.blocks;
  sum.before += layer.before;
  sum.clusters += layer.clusters;
  sum.chunks += layer.chunks;
  sum.pages += layer.pages;
  sum.rebuild += layer.rebuild;
  if (!cut) return;
  // Levels are those of the first volume; the rest holds for all.
  if (layer.cut) {
    cut->coarse_share = std::max(cut->coarse_share, layer.cut->coarse_share);
    cut->thin_blocks += layer.cut->thin_blocks;
    cut->is_final = cut->is_final && layer.cut->is_final;
    cut->will_improve = cut->will_improve || layer.cut->will_improve;
  }
  sum.cut = std::move(cut);
}

}  // namespace sluice

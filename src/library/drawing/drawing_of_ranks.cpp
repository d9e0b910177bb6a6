// The work of a Drawing together with other ranks, each of which has a part of the volume.
#include <fmt/format.h>

#include "src/base/error.h"
#include "src/base/files/byte_stream.h"
#include "src/base/values/digest.h"
#include "src/library/drawing/drawing.h"
#include "src/library/in_situ.h"
#include "src/parallel/agreement.h"

namespace sluice {

void Drawing::refuseInSitu(const char* call) const {
  if (opened_->in_situ != nullptr)
    failRequest("{}: {} is not for a volume of which each rank has a part; ranks draw() together",
                opened_->volume.name, call);
}

std::vector<Vec3d> Drawing::pointsOfRanks(const std::vector<Vec3d>& own) const {
  ByteWriter mine;
  mine.list(own);
  // The order is that of the ranks, so that each has the same list and frames the same picture.
  std::vector<Vec3d> all, more;
  for (const Message& message : opened_->in_situ->team().gatherAll(mine.bytes)) {
    ByteReader from(message);
    SLUICE_CHECK(from.list(more));
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

void Drawing::expectSameRequest(const PictureOptions& picture) const {
  expectAgreement(
      opened_->in_situ->team(),
      {{"the look", scene_.lookText()},
       {"the number of looks set", std::to_string(looks_)},
       {"the size", fmt::format("{}x{}", picture.width, picture.height)},
       {"the depth cueing", fmt::format("{}", picture.lighting.depth_cueing.value_or(0))}},
      "draw the same picture on every rank");
}

void Drawing::expectSamePicture(const PictureOptions& picture, const FrameOptions& options,
                                const View& view) const {
  const InSitu& in_situ = *opened_->in_situ;
  Digest place;
  for (const Vec3d& vector : {view.eye, view.right, view.up, view.forward})
    for (int a = 0; a < 3; ++a) place.add(static_cast<float>(vector[a]));
  place.add(static_cast<float>(view.half_height));
  const Box3 crop = options.crop.value_or(boxOf(layout().dims));
  for (int a = 0; a < 3; ++a) {
    place.add(crop.lo[a]);
    place.add(crop.hi[a]);
  }
  expectAgreement(in_situ.team(),
                  {{"the look", scene_.lookOf(options, picture)}, {"the view", "", place.value()}},
                  "draw the same picture on every rank");
  const TransferFunction& transfer = scene_.look.transfer;
  // Gradients at the edge of a box read voxels beyond it.
  const bool looks_around = options.shades || scene_.integrates(options) ||
                            !transfer.gradients.empty() || !transfer.surfaces.empty();
  if (looks_around && !in_situ.can_look_around)
    failRequest(
        "{}: lit pictures, surfaces and --quality need one layer of ghosts below and two above on "
        "each rank; lend them, or set LookOptions::light to kOff",
        opened_->volume.name);
}

}  // namespace sluice

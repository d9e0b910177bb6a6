#include "src/library/in_situ.h"

#include <algorithm>
#include <array>
#include <vector>

#include "io/lent_source.h"
#include "src/base/files/byte_stream.h"
#include "src/base/values/digest.h"
#include "src/base/values/value_counts.h"
#include "src/index/indexed_ranges.h"
#include "src/library/opening/checked_source.h"
#include "src/parallel/agreement.h"
#include "src/parallel/communication/mpi_ranks.h"

namespace sluice {
namespace {

Vec3i vecOf(const std::array<int64_t, 3>& numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

// The box of a rank in the volume, and all voxels that its array has.
struct PartBoxes {
  Box3 own, there;
};

PartBoxes boxesOf(const LentPart& part) {
  const Vec3i below = vecOf(part.box.ghosts_below), above = vecOf(part.box.ghosts_above);
  for (int a = 0; a < 3; ++a)
    if (below[a] < 0 || above[a] < 0)
      failRequest("{}: {} ghosts below and {} above along {}: must be 0 or more", part.layout.name,
                  below[a], above[a], "xyz"[a]);
  const Box3 own{vecOf(part.box.lo), vecOf(part.box.hi)};
  // Ghosts may reach out of the volume, as in periodic simulations.
  return {own, {own.lo - below, own.hi + above}};
}

std::vector<Fact> factsOf(const VolumeLayout& layout) {
  Digest place;
  for (int a = 0; a < 3; ++a) {
    place.add(layout.spacing[a]);
    place.add(layout.origin[a]);
    for (int b = 0; b < 3; ++b) place.add(layout.axes[static_cast<size_t>(a)][b]);
  }
  return {{"the volume's size",
           fmt::format("{} x {} x {}", layout.dims.x, layout.dims.y, layout.dims.z)},
          {"the voxel type", std::string(name(layout.type))},
          {"the number of time steps", std::to_string(layout.time_steps)},
          {"the volume's spacing and place", "", place.value()}};
}

// The boxes of all ranks. Throws Error, the same at each.
std::shared_ptr<const LentBoxes> gatherBoxes(Team& team, const Box3& own,
                                             const VolumeLayout& layout) {
  ByteWriter mine;
  mine.value(own);
  std::vector<Box3> boxes;
  for (const Message& message : team.gatherAll(mine.bytes)) {
    ByteReader from(message);
    Box3 box;
    SLUICE_CHECK(from.value(box));
    boxes.push_back(box);
  }
  return std::make_shared<const LentBoxes>(std::move(boxes), layout.dims, layout.name);
}

// Whether all ranks have the ghosts for lit pictures. Throws Error at a rank without those for any.
bool checkGhosts(Team& team, const LentBoxes& boxes, const PartBoxes& part,
                 const std::string& name) {
  const Box3 needed = boxes.voxelsFor(team.rank(), false);
  if (!part.there.contains(needed))
    failRequest(
        "{}: its array has the voxels from ({}, {}, {}) to ({}, {}, {}), but pictures need those "
        "from ({}, {}, {}) to ({}, {}, {}); lend one layer of ghosts above, and for lit pictures "
        "one below and two above",
        name, part.there.lo.x, part.there.lo.y, part.there.lo.z, part.there.hi.x, part.there.hi.y,
        part.there.hi.z, needed.lo.x, needed.lo.y, needed.lo.z, needed.hi.x, needed.hi.y,
        needed.hi.z);
  // One picture of all ranks is lit or is not: it takes the ghosts of all of them.
  const bool can = part.there.contains(boxes.voxelsFor(team.rank(), true));
  const std::vector<Message> all = team.gatherAll(Message(1, can ? std::byte{1} : std::byte{0}));
  return std::ranges::all_of(all, [](const Message& one) { return one[0] != std::byte{0}; });
}

// The values of the voxels of a rank's own box, each counted once.
struct PartValues {
  ValueCounts counts;
  ValueRange device_range, far_range;
};

void append(ByteWriter& to, const PartValues& values) {
  to.list(values.counts.entries);
  to.value(values.counts.changes);
  to.value(values.counts.jumps);
  to.value(values.device_range);
  to.value(values.far_range);
}

PartValues valuesIn(const Message& message) {
  ByteReader from(message);
  PartValues values;
  SLUICE_CHECK(from.list(values.counts.entries) && from.value(values.counts.changes) &&
               from.value(values.counts.jumps) && from.value(values.device_range) &&
               from.value(values.far_range));
  return values;
}

ValueRange united(const ValueRange& a, const ValueRange& b) {
  if (a.lo > a.hi) return b;
  if (b.lo > b.hi) return a;
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

// The values of all ranks together.
PartValues gatherValues(Team& team, const PartValues& own) {
  ByteWriter mine;
  append(mine, own);
  std::optional<PartValues> sum;
  for (const Message& message : team.gatherAll(mine.bytes)) {
    PartValues values = valuesIn(message);
    if (!sum) {
      sum = std::move(values);
      continue;
    }
    sum->counts = merged(sum->counts, values.counts);
    sum->device_range = united(sum->device_range, values.device_range);
    sum->far_range = united(sum->far_range, values.far_range);
  }
  return *std::move(sum);
}

PartValues valuesOf(const FillRegion& fill, const PartBoxes& part, const LentPart& lent,
                    const IndexPlaces& none, const IndexPass& pass) {
  constexpr int64_t kBlock = 64;
  VolumeLayout layout = lent.layout;
  layout.dims = part.own.size();
  const Vec3i shift = part.own.lo - part.there.lo;
  const auto source = lentSource(
      [fill, shift](int64_t time, const Box3& box, std::span<std::byte> out) {
        fill(time, {box.lo + shift, box.hi + shift}, out);
      },
      layout);
  const IndexedRanges ranges =
      indexedRanges(*source, none, 0, blockLayout(layout.dims, kBlock, 0), pass);
  return {ranges.ranges.counts, ranges.ranges.device_range, ranges.ranges.far_range};
}

// Puts the values of all ranks in the place of this rank's.
void setValues(IndexedVolume& volume, const PartValues& values) {
  auto index = std::make_shared<IndexedRanges>(*volume.index);
  index->ranges.counts = values.counts;
  index->ranges.device_range = values.device_range;
  index->ranges.far_range = values.far_range;
  volume.index = std::move(index);
  volume.values.counts = scaled(values.counts, volume.map.scale, volume.map.offset);
  const double a = volume.map.valueOf(values.device_range.lo),
               b = volume.map.valueOf(values.device_range.hi);
  volume.values.range = {std::min(a, b), std::max(a, b)};
}

}  // namespace

Ranks::Ranks(int fortran_communicator)
    : impl_(std::make_shared<Impl>(shareRanks(fortran_communicator))) {}

int Ranks::rank() const {
  return impl_->team.rank();
}

int Ranks::count() const {
  return impl_->team.ranks();
}

Ranks ranksOf(std::unique_ptr<Communicator> communicator) {
  return Ranks(std::make_shared<Ranks::Impl>(std::move(communicator)));
}

SharedVolume openShared(const LentPart& part, std::shared_ptr<Ranks::Impl> ranks,
                        const VolumeArguments& arguments, const MachineOptions& machine,
                        const IndexPass& pass) {
  Team& team = ranks->team;
  const VolumeLayout& layout = part.layout;
  if (layout.time_steps != 1)
    failRequest("{}: {} time steps, expected the one that is in memory now", layout.name,
                layout.time_steps);
  for (int a = 0; a < 3; ++a)
    if (part.box.hi[static_cast<size_t>(a)] - part.box.lo[static_cast<size_t>(a)] < 2)
      failRequest("{}: its box has {} voxels along {}, expected at least 2", layout.name,
                  part.box.hi[static_cast<size_t>(a)] - part.box.lo[static_cast<size_t>(a)],
                  "xyz"[a]);
  expectAgreement(team, factsOf(layout), "lend boxes of one volume");
  const PartBoxes boxes = boxesOf(part);
  auto in_situ = std::make_shared<InSitu>();
  in_situ->boxes = gatherBoxes(team, boxes.own, layout);
  in_situ->can_look_around = checkGhosts(team, *in_situ->boxes, boxes, layout.name);
  in_situ->ranks = std::move(ranks);

  VolumeLayout of_array = layout;
  of_array.dims = boxes.there.size();
  const FillRegion fill =
      fillFrom(part.first, of_array, part.strides.value_or(packedStrides(of_array)));
  // Nobody can tell whether an index that was kept is of these voxels.
  const IndexWish no_index{.disabled = true};
  const IndexPlaces none = indexPlaces(layout.name, no_index);
  const PartValues values = gatherValues(team, valuesOf(fill, boxes, part, none, pass));
  // Ghosts beyond the volume's faces are none of its voxels.
  const Box3 there = intersect(boxes.there, boxOf(layout.dims));
  const Vec3i cut = there.lo - boxes.there.lo;
  auto source = lentBoxSource(
      [fill, cut](int64_t time, const Box3& box, std::span<std::byte> out) {
        fill(time, {box.lo + cut, box.hi + cut}, out);
      },
      layout, there, boxes.own.lo);
  IndexedVolume volume = indexVolume(checkedSource(std::move(source), arguments), arguments,
                                     machine, kUsualNeeds, no_index, pass);
  setValues(volume, values);
  return {std::move(volume), std::move(in_situ)};
}

}  // namespace sluice

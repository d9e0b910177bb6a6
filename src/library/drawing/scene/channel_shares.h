// The shares that channels have in a picture: the options of each channel's frames, and each one's
// part of the memory. Scenes, plans and the simulator take them from here, so that a plan is that
// of the picture. Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/library/opening/indexed_volume.h"
#include "src/library/requests.h"
#include "src/render/camera/frame_options.h"
#include "src/render/session/planner.h"

namespace sluice {

// A volume with its look.
struct LayerLook {
  const IndexedVolume* volume;
  const TransferFunction* transfer;
};

// Whether a picture of so many channels blends them.
constexpr bool blends(Combine combine, size_t channels) {
  return combine == Combine::kBlend && channels > 1;
}

// The options of a volume for a frame that shows it with the first one, which has this layout. A
// level that is asked for is that of the first volume alone, and labels over it are drawn from
// coarser levels only if these hold labels. Throws as frameOn() does.
FrameOptions frameOfLayer(const IndexedVolume& volume, const TransferFunction& transfer,
                          const VolumeLayout& first, const FrameOptions& frame);
// The same of one of the channels of a frame, with its share of the bytes of a cut. Blended
// channels have one cut or none, and do not integrate. Without a size, the camera stays that of the
// first channel. Throws as haveOneCut() does, too.
FrameOptions frameOfChannel(const LayerLook& channel, const std::vector<LayerLook>& channels,
                            Combine combine, const FrameOptions& frame);

// The reason why frames cannot be blended.
struct BlendObstacle {
  std::string line;
  // Without an option for something else than how volumes are combined, they would be blended.
  bool is_option = false;
};
// The obstacle to blending such frames of volumes on these grids; nullopt: none, as far as these
// tell.
std::optional<BlendObstacle> blendObstacle(const LookArguments& look, const FrameOptions& options,
                                           const std::vector<const VolumeLayout*>& grids);
// Throws Error if a look asks for blending and such frames of the volumes cannot be blended.
void requireBlendable(const LookArguments& look, const FrameOptions& options,
                      const std::vector<LayerLook>& layers);
// How the pictures of these layers become one in such frames: as the look asks. Otherwise a volume
// over another one is blended with it if that is possible, and all others are added.
Combine combineOf(const LookArguments& look, const FrameOptions& options,
                  const std::vector<LayerLook>& layers);
// The line about two volumes that would be blended but for an option that is no choice of it;
// empty: they are blended, or added anyway.
std::string addedNote(const LookArguments& look, const FrameOptions& options,
                      const std::vector<LayerLook>& layers);
// Whether frames of a volume that is not blended take all values between two samples: they are
// asked to, and nothing stands against it.
bool integratesSamples(const FrameOptions& options, const LayerLook& layer);
// Whether its samples are near enough for that.
bool hasIntegratedSteps(const FrameOptions& options, const IndexedVolume& volume);
// Whether the volumes' finest levels are cut into blocks alike.
bool haveOneLayout(const IndexedVolume& a, const IndexedVolume& b);
// Whether the pictures of all volumes can be of one cut: each is drawn from one, and they have more
// than one level in common. Throws Error as drawsCut() does, and if they do not have the level in
// common that is asked for.
bool haveOneCut(const FrameOptions& options, const std::vector<LayerLook>& layers);

// Gives the pages of each volume room for as many blocks, so that their clusters are the same, as
// blending them takes (blended_frame.h).
void evenOutPages(const std::vector<std::pair<const IndexedVolume*, PageGeometry*>>& pages);

// The bytes that a frame holds in addition to the levels and the picture: min-max arrays, plans,
// the light that arrives if the frame's lighting looks around, and what judging surfaces of coarser
// levels takes.
uint64_t othersBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                     const FrameOptions& frame, WorkerPool& pool);

// Throws the Error again. One about a lack of memory tells if so many channels share the memory.
// `least_bytes`: see MemoryShortage.
[[noreturn]] void failOfShare(const Error& error, size_t channels,
                              std::optional<uint64_t> least_bytes = {});

// The part of a machine for each of so many channels, which share the memory evenly.
MachineOptions shareOf(MachineOptions machine, size_t channels);

// A channel's part of a picture and of the machine.
struct ChannelShare {
  LayerLook look;
  TimeStep step;
  FrameOptions frame;
  MachineOptions machine;
  PageGeometry page;          // with as many pages as its texture cache has
  uint64_t others_bytes = 0;  // see othersBytes(), and `more_bytes`
};
// The shares of the channels of such a picture, at the step that each was opened for. `more_bytes`
// are held for each channel in addition. Throws Error as frameOfChannel() does.
std::vector<ChannelShare> channelShares(const std::vector<LayerLook>& channels, Combine combine,
                                        const FrameOptions& frame, const MachineOptions& machine,
                                        uint64_t more_bytes, WorkerPool& pool);

}  // namespace sluice

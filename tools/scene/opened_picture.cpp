#include "tools/scene/opened_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "src/library/drawing/scene/picture_facts.h"

namespace sluice {

std::vector<LayerLook> OpenedPicture::looks() const {
  std::vector<LayerLook> looks;
  looks.reserve(volumes.size());
  for (size_t i = 0; i < volumes.size(); ++i) looks.push_back({&volumes[i], &transfers[i]});
  return looks;
}

std::vector<const ShownChannel*> OpenedPicture::shown() const {
  std::vector<const ShownChannel*> shown;
  shown.reserve(volumes.size());
  for (const IndexedVolume& volume : volumes) shown.push_back(&volume.channel);
  return shown;
}

OpenedPicture openPicture(PictureRequest request, FinestLevel finest, const Outputs& outputs,
                          WorkerPool& pool) {
  const FrameOptions& frame = request.frame;
  OpenedPicture opened;
  opened.volumes = openIndexedChannels(request.volume, request.look, request.resources, frame,
                                       finest, pool, outputs);
  opened.transfers.reserve(opened.volumes.size());
  for (const IndexedVolume& volume : opened.volumes)
    opened.transfers.push_back(lookFor(volume, request.look, frame.mode).transfer);
  // Names of channels are checked once it is known which channels there are.
  requireShown(request.look, opened.shown());
  // One camera shows all volumes, so that it is fitted to them together.
  std::vector<FittedVolume> fitted;
  for (const LayerLook& look : opened.looks())
    fitted.push_back({*look.volume, look.volume->step(), *look.transfer});
  requireBlendable(request.look, frame, opened.looks());
  opened.cameras = std::move(request.cameras);
  fitCameras(opened.cameras, request.fit, {std::move(fitted), frame, request.look.this_step}, {},
             request.resources, pool);
  return opened;
}

bool mustReadFinest(const OpenedPicture& picture, const FrameOptions& frame, WorkerPool& pool) {
  const VolumeLayout& first = picture.volumes.front().source->layout();
  return std::ranges::any_of(picture.looks(), [&](const LayerLook& look) {
    return mustReadFinest(*look.volume, *look.transfer, first, frame, picture.cameras, pool);
  });
}

std::vector<std::string> idleOptions(const std::set<std::string>& given, const LookArguments& look,
                                     const FrameOptions& frame, const CullingArguments& culling,
                                     const MachineOptions& machine, const OpenedPicture& opened) {
  PictureFacts facts = pictureFacts(look, frame, machine, opened.looks());
  facts.is_culled = culling.culling != Culling::kNone;
  // Plans and turns of the simulator draw no picture.
  facts.is_drawn = false;
  std::vector<std::string> lines = idleOptions(given, facts);
  for (std::string& line : lines) line = fmt::format("{}: {}", opened.volumes.front().name, line);
  return lines;
}

}  // namespace sluice

#include "tools/scene/opened_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "src/library/drawing/scene/picture_facts.h"
#include "src/library/opening/channel_looks.h"

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
  for (const IndexedVolume& volume : opened.volumes) {
    ChosenLook look = lookFor(volume, request.look, frame.mode);
    for (const std::string& warning : look.warnings)
      opened.look_warnings.push_back(
          opened.volumes.size() > 1 ? volume.channel.title() + ": " + warning : warning);
    opened.transfers.push_back(std::move(look.transfer));
  }
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

std::vector<std::string> optionWarnings(const std::set<std::string>& given,
                                        const LookArguments& look, const FrameOptions& frame,
                                        const CullingArguments& culling,
                                        const MachineOptions& machine,
                                        const OpenedPicture& opened) {
  PictureFacts facts = pictureFacts(look, frame, machine, opened.looks());
  facts.is_culled = culling.culling != Culling::kNone;
  // Plans and turns of the simulator draw no picture.
  facts.is_drawn = false;
  std::vector<std::string> lines = idleOptions(given, facts);
  for (std::string& line : lines) line = fmt::format("{}: {}", opened.volumes.front().name, line);
  std::ranges::copy(opened.look_warnings, std::back_inserter(lines));
  if (std::string note = addedNote(look, frame, opened.looks()); !note.empty())
    lines.push_back(std::move(note));
  return lines;
}

std::vector<std::string> standInNotes(const OpenedPicture& opened) {
  std::vector<const IndexedVolume*> volumes;
  volumes.reserve(opened.volumes.size());
  for (const IndexedVolume& volume : opened.volumes) volumes.push_back(&volume);
  return standInNotes(volumes);
}

std::vector<std::string> notesOf(const OpenedPicture& opened) {
  std::vector<std::string> notes;
  for (const IndexedVolume& volume : opened.volumes)
    for (const std::string& note : volume.notes)
      if (std::ranges::find(notes, note) == notes.end()) notes.push_back(note);
  return notes;
}

}  // namespace sluice

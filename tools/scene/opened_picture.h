// The channels of a picture that is not drawn, for the commands that plan pictures.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "src/library/drawing/scene/channel_shares.h"
#include "tools/command_line/outputs.h"
#include "tools/options/arguments.h"
#include "tools/scene/open_scene.h"

namespace sluice {

struct OpenedPicture {
  std::vector<IndexedVolume> volumes;       // the channels'
  std::vector<TransferFunction> transfers;  // their looks
  std::vector<Camera> cameras;              // fitted to what all of them show
  std::vector<std::string> look_warnings;   // one line each

  // They point into this, and stay right when it is moved.
  std::vector<LayerLook> looks() const;
  std::vector<const ShownChannel*> shown() const;
};

struct PictureRequest {
  const VolumeArguments& volume;
  const LookArguments& look;
  const FrameOptions& frame;
  const ResourceArguments& resources;
  FitChoice fit;
  std::vector<Camera> cameras;
};

// Opens the channels that such pictures show, once `outputs` are none of the files that they are
// read from. Throws Error, also for a look that cannot be drawn.
OpenedPicture openPicture(PictureRequest request, FinestLevel finest, const Outputs& outputs,
                          WorkerPool& pool);
// Whether the pictures have to wait for the index of the finest level of a channel.
bool mustReadFinest(const OpenedPicture& picture, const FrameOptions& frame, WorkerPool& pool);

// The options that were given for nothing, a line each with the volume's name (idle_options.h), and
// the warnings of the looks, with the addedNote(). Nothing is drawn, so that nothing is known of
// idle lights.
std::vector<std::string> optionWarnings(const std::set<std::string>& given,
                                        const LookArguments& look, const FrameOptions& frame,
                                        const CullingArguments& culling,
                                        const MachineOptions& machine, const OpenedPicture& opened);

// standInNotes() of the volumes.
std::vector<std::string> standInNotes(const OpenedPicture& opened);

// The notes of the volumes, each once.
std::vector<std::string> notesOf(const OpenedPicture& opened);

}  // namespace sluice

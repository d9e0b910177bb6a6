// The frames of a DICOM stack as a volume: their order, and the place of their voxels.
//
// Frames are sorted by their positions along the normal of their rows and columns, whatever their
// names and numbers are. Places with several frames each are time steps. Pure functions of headers.
#pragma once

#include <vector>

#include "io/dicom/dicom_stack.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// A stack as a volume.
struct DicomVolume {
  VolumeLayout layout;             // all but the name and the list of stacks
  std::vector<DicomFrame> frames;  // of all slices of all time steps
  // How stored numbers become voxels, if that differs from frame to frame; else empty, and the
  // layout has the values' scale and offset.
  std::vector<DicomLine> lines;
};

// Throws Error: two frames in the same place, places that miss a frame of some time step.
DicomVolume orderDicomStack(const std::vector<DicomHeader>& headers, const DicomStack& stack);

}  // namespace sluice

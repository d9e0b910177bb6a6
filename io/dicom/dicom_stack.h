// Stacks of DICOM frames: which ones belong together, their order, and the place of their voxels.
//
// Frames of one series with the same size, kind of pixels and directions are a stack. They are
// sorted by their positions along the normal of their rows and columns, whatever their names and
// numbers are. Places with several frames each are time steps. Pure functions of headers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/dicom/dicom_header.h"
#include "io/dicom/dicom_pixels.h"
#include "src/base/values/volume_source.h"

namespace sluice {

// A frame of a file: indices into the headers and the file's frames.
struct DicomFrame {
  size_t file = 0;
  int64_t frame = 0;
};

struct DicomStack {
  // For people and for --grid: the number of the series, with "-2" and so on behind it if several
  // stacks have the same.
  std::string name;
  std::string modality;
  DicomPixelForm form;
  std::vector<DicomFrame> frames;  // in the order of the files

  // "5 (CT, 512 x 512, 120 slices)".
  std::string described() const;
};

// The stacks of some files, in the order of their names.
std::vector<DicomStack> findDicomStacks(const std::vector<DicomHeader>& headers);

// The stack called `name`, or the largest one if `name` is empty; then with a note if there are
// others. Throws Error, which begins with `path`: none is called so (the line lists them).
const DicomStack& chooseDicomStack(const std::string& path, const std::vector<DicomStack>& stacks,
                                   const std::string& name, std::vector<std::string>& notes);

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

// Stacks of DICOM frames: which ones belong together. Frames of one series with the same size, kind
// of pixels and directions are a stack. Pure functions of headers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/dicom/dicom_header.h"
#include "io/dicom/dicom_pixels.h"

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

}  // namespace sluice

// DICOM images as a VolumeSource: a file, a folder of them, or some files.
//
// - The series and the order of the slices as dicom_stack.h has them. A folder's subfolders are
//   searched, too; files that are no DICOM images are passed over.
// - Values: a CT's are Hounsfield units, a dose's are grays: stored numbers with value_scale and
//   value_offset if one line does for all slices, else converted slice by slice, to i16 where they
//   fit and to f32 otherwise. Colors become luminance.
// - Place: millimeters, WorldFrame::kLps. A tilted gantry is a slanted axis.
// - Memory: rows of plain pixels, and whole frames of compressed ones, go through a small cache
//   (io/files/plane_bands.h).
// - Nothing that could name a patient is read (dicom_header.h).
//
// JPEG, JPEG-LS and JPEG 2000 are decoded by GDCM in a module of its own (dicom_module.h). Reads
// run on any number of threads at once.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

struct DicomOptions {
  std::string series = {};  // by the name that dicom_stack.h gives; empty: the largest
  // Limit for decoded rows until holdAtMost() changes it.
  uint64_t held_bytes = uint64_t{32} << 20;
  StopToken stop = {};  // ends opening and reading by Interrupted
};

// Throws Error: no such series, damaged files, pixels that are not understood, slices that do not
// make a volume.
std::unique_ptr<VolumeSource> openDicomFolder(const std::filesystem::path& folder,
                                              const DicomOptions& options = {});
std::unique_ptr<VolumeSource> openDicomFiles(const std::vector<std::filesystem::path>& files,
                                             const DicomOptions& options = {});

}  // namespace sluice

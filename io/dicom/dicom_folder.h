// DICOM files by name: the headers of some files, or of all files in a folder and its subfolders.
// Plain functions, any thread.
#pragma once

#include <filesystem>
#include <vector>

#include "io/dicom/dicom_header.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

// Whether one of the first files of a folder is DICOM. Subfolders are looked into if the folder has
// no pictures of other kinds.
bool isDicomFolder(const std::filesystem::path& folder);

// The images among the files below a folder, in natural order of their names. Throws Error: none of
// the files has an image; a DICOM file is damaged; the folder cannot be read. Throws Interrupted.
std::vector<DicomHeader> readDicomHeaders(const std::filesystem::path& folder,
                                          const StopToken& stop);
// All of the files, each of which must be a DICOM image. Requires: not empty.
std::vector<DicomHeader> readDicomHeaders(const std::vector<std::filesystem::path>& files,
                                          const StopToken& stop);

}  // namespace sluice

// The interface between the program and its module for compressed DICOM images.
//
// GDCM brings a dozen libraries. So all that includes its headers (dicom_module.cpp) is a library
// apart, sluice_dicom.so, opened with the first frame of JPEG, JPEG-LS or JPEG 2000
// (src/base/files/program_module.h says where from). The program reads everything else itself, and
// checks what a frame says of its own size first (dicom_frames.h).
#pragma once

#include <cstddef>
#include <span>

#include "io/dicom/dicom_header.h"
#include "io/dicom/dicom_pixels.h"

namespace sluice {

// The one function of the module: decodes a frame into pixels of the form, in this machine's byte
// order. False: the frame is damaged. `pixels` has the frame's bytes. Any thread.
using DecodeDicomFrame = bool(DicomCoding coding, const DicomPixelForm& form,
                              std::span<const std::byte> code, std::span<std::byte> pixels);
inline constexpr const char* kDecodeDicomFrame = "sluiceDecodeDicomFrame";

// The module exports this before anything is called: the version of sluice and of this interface.
inline constexpr const char* kDicomModuleVersionName = "sluiceDicomVersion";
inline constexpr const char* kDicomModuleVersion = SLUICE_VERSION " dicom module 1";

}  // namespace sluice

// The places of a DICOM file's frames, and the check of a compressed one before it is decoded.
//
// Pixels lie one frame behind the other, or in fragments of compressed frames behind a table of
// their offsets (DICOM PS3.5, A.4). Plain functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/dicom/dicom_header.h"

namespace sluice {

// The bytes of a frame in the file: its pixels, or its fragments with their headers.
struct DicomPlace {
  uint64_t begin = 0, end = 0;
};

// The place of each frame. Throws Error: fewer bytes than the frames need; fragments that are
// damaged, or that belong to no frame in particular. Requires: requireDicomPixels(header).
std::vector<DicomPlace> dicomPlaces(const DicomInput& input, const DicomHeader& header);

// The compressed bytes of a frame, out of its fragments.
std::vector<std::byte> readDicomCode(const DicomInput& input, const DicomPlace& place);

// Decodes run lengths (PS3.5, annex G) into pixels, plane after plane of colors, in this machine's
// byte order. Throws Error, which begins with `path`.
void decodeDicomRuns(const std::string& path, std::span<const std::byte> code,
                     const DicomHeader& header, std::span<std::byte> pixels);

// The bits of a pixel in a JPEG, JPEG-LS or JPEG 2000 stream. Throws Error, which begins with
// `path`, unless the stream says of itself what the header says of it: decoders take as much memory
// as a stream asks for.
int64_t checkedStreamBits(const std::string& path, std::span<const std::byte> code,
                          const DicomHeader& header);

}  // namespace sluice

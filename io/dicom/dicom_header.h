// DicomHeader: all that sluice takes from a DICOM file in front of its pixels.
//
// The members below are a complete list. No name, date, number or description of a patient, a
// person or a place is among them, so none can reach a message, a report, an index or a picture.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/dicom/dicom_elements.h"
#include "src/base/values/vec.h"

namespace sluice {

// How pixels are coded (the transfer syntax).
enum class DicomCoding { kPlain, kRunLength, kJpeg, kJpegLs, kJpeg2000 };

// Properties that frames may have in common or each for itself (PS3.3, C.7.6.16).
struct DicomFunctions {
  std::optional<Vec3d> position = {};                       // of the first pixel, in mm
  std::optional<std::array<Vec3d, 2>> directions = {};      // of columns and of rows
  std::optional<std::array<double, 2>> pixel_spacing = {};  // from row to row, column to column
  std::optional<double> thickness = {}, slice_spacing = {};
  std::optional<double> slope = {}, intercept = {};
  std::optional<int64_t> time = {};  // position in time

  // This, with the properties that it lacks from another.
  DicomFunctions orElse(const DicomFunctions& other) const;
};

struct DicomHeader {
  static constexpr int64_t kMostFrames = 100'000;
  static constexpr int64_t kMostSide = 65535;

  std::string path;
  // Names the kind of a file that is no readable image: "a DICOMDIR, ..."; empty: perhaps an image.
  std::string refusal;
  std::string syntax;    // UID; empty: not said
  std::string modality;  // two or more capital letters: "CT", or "image"
  std::string series;    // UID
  std::string instance;  // UID
  int64_t series_number = 0, acquisition_number = 0, instance_number = 0;
  DicomCoding coding = DicomCoding::kPlain;
  DicomEncoding encoding;

  int64_t columns = 0, rows = 0, frames = 1;
  int64_t samples = 1;
  std::string photometric = "MONOCHROME2";
  bool is_planar = false;  // color by color
  int64_t bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;
  std::optional<int64_t> padding, padding_limit;  // stored numbers around the image
  bool is_float = false;                          // of bits_allocated bits
  bool frames_are_times = false;                  // of a movie
  std::vector<double> plane_offsets;              // of the planes of a dose, in mm
  std::optional<double> dose_scaling;

  DicomFunctions own, shared;
  std::vector<DicomFunctions> per_frame;

  // The pixels; length DicomElement::kUndefined: in fragments.
  bool has_pixels = false;
  uint64_t pixels_at = 0;
  uint64_t pixels_length = 0;

  // Those of the frame, or else the shared ones, or else the image's own, member by member.
  DicomFunctions functionsOf(int64_t frame) const;
  uint64_t frameBytes() const {
    return static_cast<uint64_t>(columns * rows * samples * (bits_allocated / 8));
  }
};

inline constexpr uint64_t kDicomPreambleBytes = 128;

// Whether a file that begins with these bytes is a DICOM file: it has "DICM" behind a preamble, or
// begins with data elements that files without one begin with: in ascending order from group 2 or
// 8 on, and one of them is text. Voxels may look like one element.
bool looksLikeDicom(std::string_view head);

// Reads the header, as far as the pixels. Throws Error: the file is damaged; it is no DICOM file.
DicomHeader readDicomHeader(const DicomInput& input);

// Throws Error, in one line that names the file, unless the pixels of such a header can be read.
void requireDicomPixels(const DicomHeader& header);

}  // namespace sluice

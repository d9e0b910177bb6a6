#include "io/dicom/dicom_header.h"

#include "src/base/error.h"

namespace sluice {

DicomFunctions DicomFunctions::orElse(const DicomFunctions& other) const {
  DicomFunctions all = *this;
  const auto fill = [](auto& mine, const auto& theirs) {
    if (!mine) mine = theirs;
  };
  fill(all.position, other.position);
  fill(all.directions, other.directions);
  fill(all.pixel_spacing, other.pixel_spacing);
  fill(all.thickness, other.thickness);
  fill(all.slice_spacing, other.slice_spacing);
  fill(all.slope, other.slope);
  fill(all.intercept, other.intercept);
  fill(all.time, other.time);
  return all;
}

DicomFunctions DicomHeader::functionsOf(int64_t frame) const {
  const auto at = static_cast<size_t>(frame);
  DicomFunctions all = at < per_frame.size() ? per_frame[at].orElse(shared) : shared;
  all = all.orElse(own);
  if (dose_scaling && !all.slope) all.slope = dose_scaling;
  if (at < plane_offsets.size() && all.position && all.directions) {
    const Vec3d normal = cross((*all.directions)[0], (*all.directions)[1]);
    // Offsets begin at 0, or are positions along the patient's axis (PS3.3, C.8.8.3.2).
    const double offset = plane_offsets[at] - plane_offsets[0];
    all.position = *all.position + (plane_offsets[0] == 0 ? normal * offset : Vec3d{0, 0, offset});
  }
  return all;
}

void requireDicomPixels(const DicomHeader& h) {
  if (!h.refusal.empty()) fail("{}: {}", h.path, h.refusal);
  if (h.columns < 1 || h.rows < 1 || h.columns > DicomHeader::kMostSide ||
      h.rows > DicomHeader::kMostSide || h.frames < 1 || h.frames > DicomHeader::kMostFrames)
    fail(
        "{}: a DICOM image of {} x {} pixels and {} frames, expected 1 to {} pixels a side and 1 "
        "to "
        "{} frames",
        h.path, h.columns, h.rows, h.frames, DicomHeader::kMostSide, DicomHeader::kMostFrames);
  const bool is_grey = h.samples == 1 && h.photometric.starts_with("MONOCHROME");
  const bool is_color = h.samples == 3 && h.bits_allocated == 8 && !h.is_signed && !h.is_float &&
                        (h.photometric == "RGB" || h.photometric == "YBR_FULL");
  if (!is_grey && !is_color)
    fail(
        "{}: a DICOM image of {} samples a pixel of {} bits ({}), expected grey, or RGB or "
        "YBR_FULL "
        "of 8 bits",
        h.path, h.samples, h.bits_allocated, h.photometric);
  if (is_color && h.coding != DicomCoding::kPlain && h.coding != DicomCoding::kRunLength)
    fail("{}: a DICOM image of compressed colors, expected grey; gdcmconv --raw decompresses it",
         h.path);
  const int64_t bits = h.bits_allocated;
  const bool fits = h.is_float ? bits == 32 || bits == 64
                               : (bits == 8 || bits == 16 || bits == 32) && h.bits_stored >= 1 &&
                                     h.bits_stored <= bits && h.high_bit < bits &&
                                     h.high_bit >= h.bits_stored - 1;
  if (!fits)
    fail(
        "{}: a DICOM image of {} bits in {} (the highest is {}){}, expected 1 to 32 bits in 8, 16 "
        "or 32, or 32 or 64 bit floats",
        h.path, h.bits_stored, bits, h.high_bit, h.is_float ? ", floats" : "");
  const bool in_fragments = h.pixels_length == DicomElement::kUndefined;
  if (in_fragments != (h.coding != DicomCoding::kPlain))
    fail("{}: damaged DICOM file: its pixels are {}in fragments, which its transfer syntax is not",
         h.path, in_fragments ? "" : "not ");
  if (h.is_float && in_fragments)
    fail("{}: a DICOM image of compressed floats, expected them plain", h.path);
}

}  // namespace sluice

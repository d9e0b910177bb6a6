#include "io/dicom/dicom_header.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>

#include "src/base/error.h"

namespace sluice {
namespace {

// Elements that are text in every file: those of group 8 up to the class of images, without the
// two lengths and a sequence, and the names of classes, syntax and writer in group 2.
bool isText(DicomTag tag) {
  const bool is_of_image = tag > 0x00080001 && tag <= 0x00080018 && tag != 0x00080006;
  return is_of_image || (tag >= 0x00020002 && tag <= 0x00020013);
}

bool isPrintable(std::string_view value) {
  while (value.ends_with('\0')) value.remove_suffix(1);  // padding
  return std::ranges::all_of(value, [](char c) { return c >= ' ' && c <= '~'; });
}

bool startsWithElements(std::string_view head) {
  constexpr uint64_t kAnyBytes = uint64_t{1} << 40;  // the file may go on behind the head
  const DicomInput input{"", kAnyBytes, [&](uint64_t at, std::span<std::byte> out) {
                           const std::string_view rest = head.substr(std::min(at, head.size()));
                           const size_t got = std::min(out.size(), rest.size());
                           std::memcpy(out.data(), rest.data(), got);
                           return got;
                         }};
  DicomElements elements(input, 0, {});
  bool has_text = false;
  DicomTag previous = 0;
  while (const auto e = elements.next(kAnyBytes)) {
    const DicomTag group = e->tag >> 16;
    // Elements ascend, and a file without a preamble begins with group 2 or 8.
    if (e->tag <= previous || (previous < 0x00080000 && group != 2 && group != 8)) return false;
    if (group > 8 || e->isUndefined()) break;
    const std::string_view value = head.substr(std::min(e->at, head.size()), e->length);
    // Values have an even length (PS3.5, 7.1.1).
    if (e->length % 2 != 0 || (isText(e->tag) && !isPrintable(value))) return false;
    has_text = has_text || (isText(e->tag) && !value.empty());
    previous = e->tag;
    elements.skip(*e);
  }
  return has_text;
}

}  // namespace

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
  // Fragments and compression go together (PS3.5, A.4).
  if (in_fragments != (h.coding != DicomCoding::kPlain))
    fail("{}: damaged DICOM file: its pixels are {}in fragments, which its transfer syntax is not",
         h.path, in_fragments ? "" : "not ");
  if (h.is_float && in_fragments)
    fail("{}: a DICOM image of compressed floats, expected them plain", h.path);
}

bool looksLikeDicom(std::string_view head) {
  if (head.size() >= kDicomPreambleBytes + 4 && head.substr(kDicomPreambleBytes, 4) == "DICM")
    return true;
  return startsWithElements(head);
}

}  // namespace sluice

#include "io/dicom/dicom_header.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr int kMostDepth = 32;  // of sequences in sequences
constexpr DicomTag kFloatPixels = 0x7FE00008, kDoublePixels = 0x7FE00009, kPixels = 0x7FE00010;
constexpr DicomTag kSharedFunctions = 0x52009229, kFrameFunctions = 0x52009230;

struct Syntax {
  std::string_view uid;
  DicomCoding coding;
  DicomEncoding encoding = {};
};
constexpr Syntax kSyntaxes[] = {
    {"1.2.840.10008.1.2", DicomCoding::kPlain, {.explicit_types = false}},
    {"1.2.840.10008.1.2.1", DicomCoding::kPlain},
    {"1.2.840.10008.1.2.2", DicomCoding::kPlain, {.big_endian = true}},
    {"1.2.840.10008.1.2.4.50", DicomCoding::kJpeg},
    {"1.2.840.10008.1.2.4.51", DicomCoding::kJpeg},
    {"1.2.840.10008.1.2.4.57", DicomCoding::kJpeg},
    {"1.2.840.10008.1.2.4.70", DicomCoding::kJpeg},
    {"1.2.840.10008.1.2.4.80", DicomCoding::kJpegLs},
    {"1.2.840.10008.1.2.4.81", DicomCoding::kJpegLs},
    {"1.2.840.10008.1.2.4.90", DicomCoding::kJpeg2000},
    {"1.2.840.10008.1.2.4.91", DicomCoding::kJpeg2000},
    {"1.2.840.10008.1.2.5", DicomCoding::kRunLength},
};

bool consistsOf(std::string_view text, std::string_view characters) {
  return text.find_first_not_of(characters) == std::string_view::npos;
}

// The sequences within functional groups that have what is needed.
bool isFunctionSequence(DicomTag tag) {
  switch (tag) {
    case 0x00189112:  // timing and related parameters, for the time of a volume
    case 0x00209111:  // frame content
    case 0x00209113:  // plane position
    case 0x00209116:  // plane orientation
    case 0x00289110:  // pixel measures
    case 0x00289145:  // pixel value transformation
      return true;
    default:
      return false;
  }
}

class HeaderReader {
 public:
  explicit HeaderReader(const DicomInput& input) : input_(input), elements_(input, 0, {}) {
    header_.path = input.path;
  }

  DicomHeader read() {
    readMeta();
    if (!header_.refusal.empty()) return std::move(header_);
    readDataSet({.functions = &header_.own, .is_top = true}, input_.bytes, 0);
    finish();
    return std::move(header_);
  }

 private:
  // The owner of a data set's elements: the file, the functions of a frame, or nobody.
  struct Scope {
    DicomFunctions* functions = nullptr;
    bool is_top = false;
  };

  [[noreturn]] void failDamaged(std::string_view what) const {
    fail("{}: damaged DICOM file: {}", input_.path, what);
  }

  // The elements in front of the data set, which say how it is encoded.
  void readMeta() {
    constexpr size_t kLookedAtBytes = 4096;  // as much as when the file's format was found
    constexpr std::string_view kMark = "DICM";
    std::string head(kLookedAtBytes, '\0');
    head.resize(input_.readSome(0, std::as_writable_bytes(std::span(head))));
    if (!looksLikeDicom(head))
      fail(
          "{}: expected a DICOM file, found neither DICM at byte {} nor a data element at the "
          "start",
          input_.path, kDicomPreambleBytes);
    const bool has_preamble = head.size() > kDicomPreambleBytes &&
                              head.compare(kDicomPreambleBytes, kMark.size(), kMark) == 0;
    elements_.moveTo(has_preamble ? kDicomPreambleBytes + kMark.size() : 0);
    while (nextIsMeta()) {
      const auto e = elements_.next(input_.bytes);
      if (!e) break;
      if (e->isUndefined()) failDamaged("an element in front of its data set has no length");
      if (e->tag == 0x00020010) header_.syntax = uid(*e);
      if (e->tag == 0x00020002 && elements_.text(*e) == "1.2.840.10008.1.3.10")
        header_.refusal =
            "a DICOMDIR, which is an index of other files; give the folder that it lies in";
      elements_.skip(*e);
    }
    setSyntax();
  }

  // Whether an element of group 2 follows. What follows it may be in another byte order.
  bool nextIsMeta() {
    std::array<std::byte, 2> group{};
    return input_.readSome(elements_.position(), group) == 2 && group[0] == std::byte{2} &&
           group[1] == std::byte{0};
  }

  void setSyntax() {
    if (header_.syntax.empty()) {
      header_.encoding = encodingOf(elements_.position());
    } else {
      const auto* const found =
          std::find_if(std::begin(kSyntaxes), std::end(kSyntaxes),
                       [&](const Syntax& syntax) { return syntax.uid == header_.syntax; });
      if (found == std::end(kSyntaxes)) {
        if (header_.refusal.empty())
          header_.refusal = fmt::format(
              "a DICOM file in the transfer syntax {}, expected plain, RLE, JPEG, JPEG-LS or JPEG "
              "2000; gdcmconv --raw converts it",
              header_.syntax);
        return;
      }
      header_.coding = found->coding;
      header_.encoding = found->encoding;
    }
    elements_.setEncoding(header_.encoding);
  }

  // Guesses the encoding of a data set that does not name it: explicit types are letters.
  DicomEncoding encodingOf(uint64_t at) {
    std::array<std::byte, 6> head{};
    input_.readSome(at, head);
    const auto letter = [&](size_t i) {
      return std::to_integer<int>(head[i]) >= 'A' && std::to_integer<int>(head[i]) <= 'Z';
    };
    return {.explicit_types = letter(4) && letter(5),
            // Groups are small numbers, so that the first byte of one is zero only in big-endian
            // order.
            .big_endian = head[0] == std::byte{0} && head[1] != std::byte{0}};
  }

  void readDataSet(const Scope& scope, uint64_t end, int depth) {
    if (depth > kMostDepth) failDamaged("its sequences are nested too deeply");
    while (const auto e = elements_.next(end)) {
      // An item of undefined length ends by a delimiter (PS3.5, 7.5.1).
      if (e->tag == kDicomItemEnd || e->tag == kDicomSequenceEnd) {
        if (scope.is_top) failDamaged("a sequence ends that did not begin");
        return;
      }
      if (scope.is_top &&
          (e->tag == kPixels || e->tag == kFloatPixels || e->tag == kDoublePixels)) {
        notePixels(*e);
        return;
      }
      // Elements ascend, so that no pixels follow.
      if (scope.is_top && e->tag > kPixels) return;
      if (e->is_sequence || isWantedSequence(scope, e->tag)) {
        readSequence(scope, *e, depth);
        continue;
      }
      if (scope.functions != nullptr) takeFunction(*scope.functions, *e);
      if (scope.is_top) takeOwn(*e);
      elements_.skip(*e);
    }
  }

  static bool isWantedSequence(const Scope& scope, DicomTag tag) {
    if (scope.is_top) return tag == kSharedFunctions || tag == kFrameFunctions;
    return scope.functions != nullptr && isFunctionSequence(tag);
  }

  void readSequence(const Scope& scope, const DicomElement& sequence, int depth) {
    const bool is_wanted = isWantedSequence(scope, sequence.tag);
    if (!is_wanted && !sequence.isUndefined()) {
      elements_.skip(sequence);
      return;
    }
    const DicomEncoding outside = elements_.encoding();
    // Its items have implicit types (PS3.5, 6.2.2).
    if (sequence.is_unknown_sequence) elements_.setEncoding({.explicit_types = false});
    const uint64_t end = sequence.isUndefined() ? input_.bytes : sequence.at + sequence.length;
    while (const auto item = elements_.next(end)) {
      if (item->tag == kDicomSequenceEnd) break;
      if (item->tag != kDicomItem) failDamaged("something else than an item in a sequence");
      const uint64_t item_end = item->isUndefined() ? end : std::min(end, item->at + item->length);
      readDataSet(is_wanted ? scopeOf(scope, sequence.tag) : Scope{}, item_end, depth + 1);
      // An item may end before its length says, for instance by a damaged delimiter.
      if (!item->isUndefined()) elements_.moveTo(item_end);
    }
    if (!sequence.isUndefined()) elements_.moveTo(end);
    elements_.setEncoding(outside);
  }

  // The scope of an item of a wanted sequence.
  Scope scopeOf(const Scope& scope, DicomTag sequence) {
    if (!scope.is_top) return {.functions = scope.functions};
    if (sequence == kSharedFunctions) return {.functions = &header_.shared};
    if (static_cast<int64_t>(header_.per_frame.size()) >= DicomHeader::kMostFrames)
      failDamaged("more frames than can be");
    return {.functions = &header_.per_frame.emplace_back()};
  }

  std::string uid(const DicomElement& e) {
    std::string text = elements_.text(e);
    constexpr size_t kMostUid = 64;
    if (text.size() > kMostUid || !consistsOf(text, "0123456789."))
      failDamaged(fmt::format("element {} is no unique identifier", tagText(e.tag)));
    return text;
  }

  std::vector<double> decimals(const DicomElement& e, size_t count) {
    std::vector<double> numbers = elements_.decimals(e);
    if (!numbers.empty() && numbers.size() < count)
      failDamaged(fmt::format("element {} has {} numbers, expected {}", tagText(e.tag),
                              numbers.size(), count));
    return numbers;
  }

  void takeDecimal(const DicomElement& e, std::optional<double>& into) {
    if (const auto numbers = decimals(e, 1); !numbers.empty()) into = numbers[0];
  }

  void takeFunction(DicomFunctions& f, const DicomElement& e) {
    switch (e.tag) {
      case 0x00180050:
        return takeDecimal(e, f.thickness);
      case 0x00180088:
        return takeDecimal(e, f.slice_spacing);
      case 0x00281052:
        return takeDecimal(e, f.intercept);
      case 0x00281053:
        return takeDecimal(e, f.slope);
      case 0x00200100:  // temporal position identifier
        f.time = elements_.integer(e);
        return;
      case 0x00209128:  // temporal position index
        f.time = elements_.number(e);
        return;
      case 0x00181164:  // imager pixel spacing: at the detector, unless the other one is known
      case 0x00280030:
        if (const auto n = decimals(e, 2); !n.empty() && !(e.tag == 0x00181164 && f.pixel_spacing))
          f.pixel_spacing = {n[0], n[1]};
        return;
      case 0x00200032:
        if (const auto n = decimals(e, 3); !n.empty()) f.position = Vec3d{n[0], n[1], n[2]};
        return;
      case 0x00200037:
        if (const auto n = decimals(e, 6); !n.empty())
          f.directions = {Vec3d{n[0], n[1], n[2]}, Vec3d{n[3], n[4], n[5]}};
        return;
      default:
        return;
    }
  }

  void takeOwn(const DicomElement& e) {
    DicomHeader& h = header_;
    switch (e.tag) {
      case 0x00041220:
        h.refusal = "a DICOMDIR, which is an index of other files; give the folder that it lies in";
        return;
      case 0x00080018:
        h.instance = uid(e);
        return;
      case 0x00080060:
        h.modality = elements_.text(e);
        return;
      case 0x0020000E:
        h.series = uid(e);
        return;
      case 0x00200011:
        h.series_number = elements_.integer(e);
        return;
      case 0x00200012:
        h.acquisition_number = elements_.integer(e);
        return;
      case 0x00200013:
        h.instance_number = elements_.integer(e);
        return;
      case 0x00280002:
        h.samples = elements_.number(e);
        return;
      case 0x00280004:
        h.photometric = elements_.text(e);
        return;
      case 0x00280006:
        h.is_planar = elements_.number(e) != 0;
        return;
      case 0x00280008:
        h.frames = elements_.integer(e);
        return;
      case 0x00280009:  // frame increment pointer: to a frame time or a vector of them
        if (e.length == 4) takeIncrement(e);
        return;
      case 0x00280010:
        h.rows = elements_.number(e);
        return;
      case 0x00280011:
        h.columns = elements_.number(e);
        return;
      case 0x00280100:
        h.bits_allocated = elements_.number(e);
        return;
      case 0x00280101:
        h.bits_stored = elements_.number(e);
        return;
      case 0x00280102:
        h.high_bit = elements_.number(e);
        return;
      case 0x00280103:
        h.is_signed = elements_.number(e) != 0;
        return;
      case 0x00280120:
        h.padding = paddingOf(e);
        return;
      case 0x00280121:
        h.padding_limit = paddingOf(e);
        return;
      case 0x3004000C:
        h.plane_offsets = elements_.decimals(e);
        return;
      case 0x3004000E:
        return takeDecimal(e, h.dose_scaling);
      default:
        return;
    }
  }

  // The type of pixels stands in front. Another length than 16 bits is passed over.
  std::optional<int64_t> paddingOf(const DicomElement& e) {
    if (e.length != 2) return std::nullopt;
    const uint32_t number = elements_.number(e);
    return header_.is_signed ? int64_t{static_cast<int16_t>(number)} : int64_t{number};
  }

  // A tag as a value: its two halves are numbers of their own.
  void takeIncrement(const DicomElement& e) {
    DicomElement half = e;
    half.length = 2;
    const uint32_t group = elements_.number(half);
    half.at += 2;
    const uint32_t element = elements_.number(half);
    header_.frames_are_times = group == 0x0018 && (element == 0x1063 || element == 0x1065);
  }

  void notePixels(const DicomElement& e) {
    header_.has_pixels = true;
    header_.is_float = e.tag != kPixels;
    header_.pixels_at = e.at;
    header_.pixels_length = e.length;
  }

  void finish() {
    // These texts are printed, so a damaged file may not put control characters into them.
    DicomHeader& h = header_;
    constexpr size_t kMostLetters = 16;
    if (h.modality.empty() || h.modality.size() > kMostLetters ||
        !consistsOf(h.modality, "ABCDEFGHIJKLMNOPQRSTUVWXYZ"))
      h.modality = "image";
    if (h.photometric.size() > kMostLetters || h.photometric.empty() ||
        !consistsOf(h.photometric, "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_ "))
      h.photometric = "unknown";
    if (h.bits_stored == 0) h.bits_stored = h.bits_allocated;
    if (h.high_bit == 0) h.high_bit = h.bits_stored - 1;
    if (h.refusal.empty() && !h.has_pixels)
      h.refusal = fmt::format("a DICOM file without pixels ({}), expected an image", h.modality);
  }

  const DicomInput& input_;
  DicomElements elements_;
  DicomHeader header_;
};

}  // namespace

DicomHeader readDicomHeader(const DicomInput& input) {
  return HeaderReader(input).read();
}

}  // namespace sluice

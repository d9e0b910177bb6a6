// The data elements of a DICOM file, in the order of the file (DICOM PS3.5, section 7).
//
// A file is read through a window of a few KiB, and values that nobody asks for are skipped, so a
// header takes the same memory whatever its size. No text of a file is ever put into a message:
// lengths that are wrong make one element look like another, and one of them is the patient's name.
// One thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sluice {

// The bytes of a file.
struct DicomInput {
  std::string path;  // for messages
  uint64_t bytes = 0;
  // Fills `out` from an offset on; returns how many bytes the file had.
  std::function<size_t(uint64_t offset, std::span<std::byte> out)> readSome;
};

// Group and element: 0x00280010 is (0028,0010).
using DicomTag = uint32_t;
std::string tagText(DicomTag tag);

inline constexpr DicomTag kDicomItem = 0xFFFEE000, kDicomItemEnd = 0xFFFEE00D,
                          kDicomSequenceEnd = 0xFFFEE0DD;

struct DicomEncoding {
  bool explicit_types = true;  // each element names its type (VR)
  bool big_endian = false;
};

struct DicomElement {
  static constexpr uint32_t kUndefined = 0xFFFFFFFF;  // up to a delimiter

  DicomTag tag = 0;
  uint64_t at = 0;      // offset of the value
  uint32_t length = 0;  // of the value, or kUndefined
  bool is_sequence = false;
  // Its items are encoded without types whatever the data set is (PS3.5, 6.2.2, note on UN).
  bool is_unknown_sequence = false;

  bool isUndefined() const { return length == kUndefined; }
};

class DicomElements {
 public:
  // `input` must outlive it.
  DicomElements(const DicomInput& input, uint64_t at, DicomEncoding encoding)
      : input_(input), at_(at), encoding_(encoding) {}

  DicomEncoding encoding() const { return encoding_; }
  void setEncoding(DicomEncoding encoding) { encoding_ = encoding; }
  uint64_t position() const { return at_; }
  void moveTo(uint64_t at) { at_ = at; }

  // The element at the position, which moves behind its length. nullopt: fewer than 8 bytes are
  // left before `end`. Throws Error: its value ends behind the file's end.
  std::optional<DicomElement> next(uint64_t end);
  // Moves behind the value. Requires: a length that is not undefined.
  void skip(const DicomElement& element) { at_ = element.at + element.length; }

  // The value as it is used, without padding. Throws Error if it is longer than kMostTextBytes.
  std::string text(const DicomElement& element);
  // Numbers written as text, with backslashes between them, any number of them. Throws Error if one
  // of them is none, or not finite.
  std::vector<double> decimals(const DicomElement& element);
  // The first of them as a whole number.
  int64_t integer(const DicomElement& element);
  // A binary number of 16 or 32 bits. Throws Error for another length.
  uint32_t number(const DicomElement& element);

  static constexpr uint32_t kMostTextBytes = uint32_t{2} << 20;

 private:
  // Fewer bytes than asked for only at the file's end.
  size_t take(uint64_t at, std::span<std::byte> out);
  uint32_t binary(std::span<const std::byte> bytes) const;

  const DicomInput& input_;
  uint64_t at_ = 0;
  DicomEncoding encoding_;
  std::array<std::byte, 4096> window_;
  uint64_t window_at_ = 0;
  size_t window_size_ = 0;
};

}  // namespace sluice

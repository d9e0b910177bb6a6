#include "io/dicom/dicom_elements.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "src/base/error.h"
#include "src/base/files/number_text.h"
#include "src/base/values/text_parts.h"

namespace sluice {
namespace {

// Types whose length has 32 bits, behind two bytes that are reserved (PS3.5, table 7.1-1).
constexpr std::array<std::string_view, 13> kLongTypes = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                                         "SV", "UC", "UN", "UR", "UT", "UV"};

bool isUpper(char c) {
  return c >= 'A' && c <= 'Z';
}

// Values are filled up to an even length, texts with blanks and others with zeros.
constexpr std::string_view kPadding(" \0", 2);

}  // namespace

std::string tagText(DicomTag tag) {
  return fmt::format("({:04X},{:04X})", tag >> 16, tag & 0xFFFF);
}

size_t DicomElements::take(uint64_t at, std::span<std::byte> out) {
  // Element headers are 8 or 12 bytes: a window saves a read of the file for each.
  if (out.size() > window_.size()) return input_.readSome(at, out);
  const bool is_inside = at >= window_at_ && at - window_at_ < window_size_ &&
                         out.size() <= window_size_ - (at - window_at_);
  if (!is_inside) {
    window_size_ = input_.readSome(at, window_);
    window_at_ = at;
  }
  const size_t got = std::min(out.size(), window_size_ - (at - window_at_));
  std::copy_n(window_.begin() + static_cast<ptrdiff_t>(at - window_at_), got, out.begin());
  return got;
}

uint32_t DicomElements::binary(std::span<const std::byte> bytes) const {
  uint32_t value = 0;
  for (size_t i = 0; i < bytes.size(); ++i) {
    const size_t place = encoding_.big_endian ? i : bytes.size() - 1 - i;
    value = value << 8 | std::to_integer<uint32_t>(bytes[place]);
  }
  return value;
}

std::optional<DicomElement> DicomElements::next(uint64_t end) {
  std::array<std::byte, 12> head;
  const std::span<const std::byte> all(head);
  const uint64_t stop = std::min(end, input_.bytes);
  if (at_ >= stop || stop - at_ < 8 || take(at_, std::span(head).first(8)) < 8) return std::nullopt;
  DicomElement element;
  element.tag = binary(all.first(2)) << 16 | binary(all.subspan(2, 2));
  element.length = binary(all.subspan(4, 4));
  uint64_t head_bytes = 8;
  const char type[2] = {static_cast<char>(head[4]), static_cast<char>(head[5])};
  // Delimiters have no type, and some writers leave it out elsewhere, too.
  const bool has_type = encoding_.explicit_types && element.tag >> 16 != 0xFFFE &&
                        isUpper(type[0]) && isUpper(type[1]);
  if (has_type) {
    // Explicit types: a length of 16 bits behind the type, or of 32 bits behind two reserved bytes
    // (PS3.5, 7.1.2).
    const std::string_view name(type, 2);
    if (std::find(kLongTypes.begin(), kLongTypes.end(), name) == kLongTypes.end()) {
      element.length = binary(all.subspan(6, 2));
    } else {
      if (stop - at_ < 12 || take(at_, head) < 12) return std::nullopt;
      element.length = binary(all.subspan(8, 4));
      head_bytes = 12;
    }
    element.is_sequence = name == "SQ";
    // Such a sequence is encoded with implicit types, whatever the file's syntax is (PS3.5, 6.2.2).
    element.is_unknown_sequence = name == "UN" && element.isUndefined();
  }
  element.is_sequence = element.is_sequence || element.isUndefined();
  element.at = at_ + head_bytes;
  at_ = element.at;
  // A damaged length would lead the reader to bytes that are no element.
  if (!element.isUndefined() &&
      (element.at > input_.bytes || element.length > input_.bytes - element.at))
    fail(
        "{}: damaged DICOM file: element {} of {} bytes at {}, in a file of {}; it was cut short "
        "or "
        "is none",
        input_.path, tagText(element.tag), element.length, element.at, input_.bytes);
  return element;
}

std::string DicomElements::text(const DicomElement& element) {
  if (element.length > kMostTextBytes)
    fail("{}: damaged DICOM file: element {} of {} bytes, expected at most {}", input_.path,
         tagText(element.tag), element.length, kMostTextBytes);
  std::string value(element.length, '\0');
  take(element.at, std::as_writable_bytes(std::span(value)));
  return std::string(trimmed(value, kPadding));
}

std::vector<double> DicomElements::decimals(const DicomElement& element) {
  const std::string value = text(element);
  std::vector<double> numbers;
  for (std::string_view rest = value; !rest.empty();) {
    const size_t end = std::min(rest.find('\\'), rest.size());
    std::string_view one = trimmed(rest.substr(0, end), kPadding);
    // std::from_chars() takes no plus sign, and the type DS may have one.
    if (one.starts_with('+')) one.remove_prefix(1);
    const auto number = numberOf(one);
    if (!number)
      fail("{}: damaged DICOM file: element {} has something else than numbers", input_.path,
           tagText(element.tag));
    numbers.push_back(*number);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return numbers;
}

int64_t DicomElements::integer(const DicomElement& element) {
  const std::vector<double> numbers = decimals(element);
  constexpr double kMost = 2147483647;  // of the type IS
  if (numbers.empty()) return 0;
  if (std::abs(numbers[0]) > kMost || numbers[0] != std::floor(numbers[0]))
    fail("{}: damaged DICOM file: element {} is no whole number", input_.path,
         tagText(element.tag));
  return static_cast<int64_t>(numbers[0]);
}

uint32_t DicomElements::number(const DicomElement& element) {
  std::array<std::byte, 4> bytes;
  if (element.length != 2 && element.length != 4)
    fail("{}: damaged DICOM file: element {} of {} bytes, expected a number of 2 or 4", input_.path,
         tagText(element.tag), element.length);
  take(element.at, std::span(bytes).first(element.length));
  return binary(std::span<const std::byte>(bytes).first(element.length));
}

}  // namespace sluice

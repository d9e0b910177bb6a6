#include "io/headers/raw/raw_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "io/headers/header_fields.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

// The numbers of "256x256x225"; empty when the text is something else.
std::vector<int64_t> numbersBetweenX(std::string_view text) {
  std::vector<int64_t> numbers;
  for (;;) {
    const size_t end = std::min(text.find('x'), text.size());
    const std::string_view digits = text.substr(0, end);
    const std::optional<int64_t> number = parseInteger(digits);
    if (!number || *number < 1 || digits[0] == '+') return {};
    numbers.push_back(*number);
    if (end == text.size()) return numbers;
    text.remove_prefix(end + 1);
  }
}

bool hasDigit(std::string_view text) {
  return text.find_first_of("0123456789") != std::string_view::npos;
}

}  // namespace

RawName parseRawName(std::string_view file_name) {
  RawName found;
  const std::string lower = lowercase(file_name);
  const std::string_view view = lower;
  for (size_t begin = 0; begin < view.size();) {
    const size_t end = std::min(view.find_first_of("_-. ", begin), view.size());
    const std::string_view part = view.substr(begin, end - begin);
    begin = end + 1;
    const std::vector<int64_t> numbers = numbersBetweenX(part);
    if (numbers.size() == 3 || numbers.size() == 4) {
      found.dims = Vec3i{numbers[0], numbers[1], numbers[2]};
      found.time_steps.reset();
      if (numbers.size() == 4) found.time_steps = numbers[3];
    }
    // A word such as "double" in front of the dimensions is more likely part of a title.
    const std::optional<VoxelType> type = parseVoxelType(part);
    if (type && (found.dims || hasDigit(part))) found.type = type;
    if (found.dims && part == "le") found.byte_order = std::endian::little;
    if (found.dims && part == "be") found.byte_order = std::endian::big;
  }
  return found;
}

std::string falseInName(std::string_view file_name, Vec3i dims, VoxelType type, std::endian order) {
  const RawName said = parseRawName(file_name);
  if (said.dims && *said.dims != dims)
    return fmt::format("{} x {} x {} voxels", said.dims->x, said.dims->y, said.dims->z);
  if (said.time_steps && *said.time_steps != 1)
    return fmt::format("{} time steps", *said.time_steps);
  if (said.type && *said.type != type) return std::string(name(*said.type));
  if (said.byte_order && *said.byte_order != order && bytesPerVoxel(type) > 1)
    return *said.byte_order == std::endian::big ? "big-endian" : "little-endian";
  return "";
}

}  // namespace sluice

#include "io/dicom/dicom_stack.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kMostListed = 8;

// Directions, rounded: writers print the same ones with other last digits.
std::array<int64_t, 6> roundedDirections(const DicomFunctions& functions) {
  std::array<int64_t, 6> rounded{};
  if (!functions.directions) return rounded;
  constexpr double kSteps = 1e4;
  for (int i = 0; i < 6; ++i) {
    const double part = (*functions.directions)[static_cast<size_t>(i / 3)][i % 3];
    rounded[static_cast<size_t>(i)] = std::llround(std::clamp(part, -2.0, 2.0) * kSteps);
  }
  return rounded;
}

// The size of a pixel, rounded: one that differs by less moves a pixel of a thousand by a tenth.
std::array<int64_t, 2> roundedSpacing(const DicomFunctions& functions) {
  if (!functions.pixel_spacing) return {};
  const auto rounded = [](double mm) {
    constexpr double kSteps = 1e4;  // a factor of e
    return std::llround(kSteps * std::log(std::max(std::abs(mm), 1e-30)));
  };
  return {rounded((*functions.pixel_spacing)[0]), rounded((*functions.pixel_spacing)[1])};
}

// The properties that all frames of a stack share.
using StackKey =
    std::tuple<int64_t, std::string, std::array<int64_t, 6>, std::array<int64_t, 2>, std::string,
               int64_t, int64_t, int64_t, int64_t, int64_t, int64_t, bool, bool, bool, bool>;
StackKey keyOf(const DicomHeader& h, const DicomFunctions& functions) {
  return {h.series_number,
          h.series,
          roundedDirections(functions),
          roundedSpacing(functions),
          h.modality,
          h.columns,
          h.rows,
          h.samples,
          h.bits_allocated,
          h.bits_stored,
          h.high_bit,
          h.is_signed,
          h.is_float,
          h.frames_are_times,
          functions.position.has_value()};
}

}  // namespace

std::string DicomStack::described() const {
  return fmt::format("{} ({}, {} x {}, {} slice{})", name, modality, form.columns, form.rows,
                     frames.size(), frames.size() == 1 ? "" : "s");
}

std::vector<DicomStack> findDicomStacks(const std::vector<DicomHeader>& headers) {
  std::map<StackKey, DicomStack> found;
  for (size_t file = 0; file < headers.size(); ++file) {
    const DicomHeader& h = headers[file];
    for (int64_t frame = 0; frame < std::clamp<int64_t>(h.frames, 1, DicomHeader::kMostFrames);
         ++frame) {
      DicomStack& stack = found[keyOf(h, h.functionsOf(frame))];
      stack.frames.push_back({file, frame});
      stack.modality = h.modality;
      stack.form = dicomPixelForm(h);
    }
  }
  std::vector<DicomStack> stacks;
  std::map<int64_t, int> named;
  for (auto& [key, stack] : found) {
    const int64_t number = std::get<0>(key);
    const int before = named[number]++;
    stack.name = before == 0 ? fmt::format("{}", number) : fmt::format("{}-{}", number, before + 1);
    stacks.push_back(std::move(stack));
  }
  return stacks;
}

const DicomStack& chooseDicomStack(const std::string& path, const std::vector<DicomStack>& stacks,
                                   const std::string& name, std::vector<std::string>& notes) {
  const auto others = [&](const DicomStack* taken) {
    std::string list;
    size_t listed = 0;
    for (const DicomStack& stack : stacks) {
      if (&stack == taken) continue;
      if (listed++ == kMostListed) return list + ", ...";
      list += fmt::format("{}{}", list.empty() ? "" : ", ", stack.described());
    }
    return list;
  };
  if (!name.empty()) {
    const auto found = std::find_if(stacks.begin(), stacks.end(),
                                    [&](const DicomStack& stack) { return stack.name == name; });
    if (found == stacks.end())
      failRequest("{}: --grid {}: no series of that number, expected one of {}", path, name,
                  others(nullptr));
    return *found;
  }
  // A folder of a study also has scouts and localizers of a few slices.
  const DicomStack& largest = *std::max_element(
      stacks.begin(), stacks.end(),
      [](const DicomStack& a, const DicomStack& b) { return a.frames.size() < b.frames.size(); });
  if (stacks.size() > 1)
    notes.push_back(fmt::format("{}: series {} of {} is read; --grid takes another of {}", path,
                                largest.described(), stacks.size(), others(&largest)));
  return largest;
}

}  // namespace sluice

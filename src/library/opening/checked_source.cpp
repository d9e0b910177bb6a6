#include "src/library/opening/checked_source.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "io/web/address.h"
#include "src/base/error.h"
#include "src/library/opening/thick_source.h"

namespace sluice {

std::unique_ptr<VolumeSource> openSource(const VolumeArguments& arguments) {
  return checkedSource(openVolume(arguments.inputs, arguments.open), arguments);
}

std::unique_ptr<VolumeSource> checkedSource(std::unique_ptr<VolumeSource> opened,
                                            const VolumeArguments& arguments) {
  auto source = withThickness(std::move(opened));
  const int64_t steps = source->layout().time_steps;
  if (arguments.time >= 0 && arguments.time < steps) return source;
  // Users give the number in a file's name where the place in the series is meant, so the message
  // names the step of that number.
  const std::vector<int64_t> numbers = numbersOfSteps(*source);
  const int64_t step = std::ranges::find(numbers, arguments.time) - numbers.begin();
  const bool is_number = step < std::ssize(numbers);
  // Numbers that begin above 0 were meant by who asks for one beyond them.
  const bool beyond_numbers =
      !numbers.empty() && numbers.front() > 0 && arguments.time > numbers.back();
  // A number that is a file's asks for no step beyond the last one.
  const auto missing = missingStep(*source, is_number        ? step
                                            : beyond_numbers ? steps
                                                             : arguments.time);
  const std::string gap = missing ? "; " + *missing + " is missing" : "";
  const std::string name = withoutSecrets(arguments.inputs.front());
  constexpr const char* kCounted = "time steps are counted from 0, not by the files' numbers";
  if (is_number)
    failRequest("{}: --time {}: {}: the file of that number is step {} of {}; give --time {}{}",
                name, arguments.time, kCounted, step, steps, step, gap);
  if (beyond_numbers)
    failRequest("{}: --time {}: {}: the last file has number {} and is step {} of {}{}", name,
                arguments.time, kCounted, numbers.back(), steps - 1, steps, gap);
  failRequest("{}: --time {}: the volume has {} time step{}, counted from 0{}", name,
              arguments.time, steps, steps == 1 ? "" : "s", gap);
}

}  // namespace sluice

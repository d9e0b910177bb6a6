#include "src/base/files/numbered_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "src/base/error.h"

namespace sluice {

namespace fs = std::filesystem;

namespace {

// The place of the number in a name: `length` characters from `at`, written with at least `digits`
// digits.
struct NumberPlace {
  size_t at = 0, length = 0;
  int digits = 0;
};

std::optional<NumberPlace> numberPlace(const std::string& name, const std::string& file) {
  constexpr int kMostDigits = 20;
  const size_t percent = file.find('%'), hash = file.find('#');
  if (percent == std::string::npos && hash == std::string::npos) return std::nullopt;
  const auto refuse = [&] {
    failRequest("{}: expected one place for the number, as in turn_####.png or turn_%04d.png",
                name);
  };
  NumberPlace place;
  if (hash != std::string::npos) {
    place.at = hash;
    place.length = file.find_first_not_of('#', hash) - hash;
    if (place.length > file.size()) place.length = file.size() - hash;
    place.digits = static_cast<int>(place.length);
  } else {
    const size_t end = file.find_first_not_of("0123456789", percent + 1);
    // At most two digits, so that std::stoi() cannot overflow.
    if (end == std::string::npos || file[end] != 'd' || end - percent > 3) refuse();
    place = {percent, end + 1 - percent,
             end == percent + 1 ? 1 : std::stoi(file.substr(percent + 1, end - percent - 1))};
  }
  if (place.digits > kMostDigits) refuse();
  const std::string rest = file.substr(place.at + place.length);
  if (rest.find_first_of("%#") != std::string::npos ||
      (hash != std::string::npos && percent != std::string::npos))
    refuse();
  return place;
}

}  // namespace

fs::path numberedName(const std::string& name, int64_t number, bool numbered) {
  fs::path path(name);
  const std::string file = path.filename().string();
  if (const auto place = numberPlace(name, file)) {
    const std::string digits = fmt::format("{:0{}}", number, std::max(1, place->digits));
    return path.parent_path() /
           (file.substr(0, place->at) + digits + file.substr(place->at + place->length));
  }
  if (!numbered) return path;
  return path.parent_path() /
         fmt::format("{}_{:03}{}", path.stem().string(), number, path.extension().string());
}

}  // namespace sluice

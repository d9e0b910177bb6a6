#include "tools/scene/empty_pictures.h"

#include <fmt/format.h>

#include "tools/command_line/console.h"

namespace sluice {

void EmptyPictures::add(const std::string& name, const std::string& why) {
  ++pictures_;
  if (why.empty()) return;
  if (++empty_ == 1) first_ = fmt::format("{} shows nothing: {}", name, why);
}

void EmptyPictures::warn() const {
  if (empty_ == 0) return;
  const int64_t others = empty_ - 1;
  printWarning(others == 0 ? first_
                           : fmt::format("{}; {} more of the {} pictures show nothing", first_,
                                         others, pictures_));
}

}  // namespace sluice

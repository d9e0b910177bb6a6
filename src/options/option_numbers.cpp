#include "src/options/option_numbers.h"

#include <algorithm>
#include <cmath>

#include "src/base/looks/channel_look.h"
#include "src/base/looks/label_look.h"
#include "src/base/looks/surface_look.h"
#include "src/base/values/vec.h"

namespace sluice {
namespace {

using Numbers = std::vector<std::optional<double>>;

// Visits the numbers of a value in their order, to collect them or to replace them.
class Visitor {
 public:
  // `given`: null to collect alone.
  Visitor(const OptionKind& kind, const Numbers* given) : form_(kind.form), given_(given) {}

  const OptionNumbers& found() const { return found_; }

  void operator()(bool& /*flag*/) {}
  void operator()(std::string& /*word*/) {}
  void operator()(double& number) {
    std::optional<double> held = number;
    visit(held);
    number = *held;
  }
  void operator()(int64_t& whole) {
    auto number = static_cast<double>(whole);
    (*this)(number);
    // A whole number that no double holds stays as it is, unless it is replaced.
    if (number != static_cast<double>(whole)) whole = std::llround(number);
  }
  void operator()(OptionReals& reals) {
    const OptionReals before = reals;
    for (double& number : reals) (*this)(number);
    // Numbers between two valid values may be invalid together: a range must not become empty.
    if (form_ == OptionForm::kRange && reals[0] == reals[1]) reals = before;
  }
  void operator()(OptionWholes& wholes) {
    for (int64_t& whole : wholes) (*this)(whole);
    // A box has a voxel along each axis.
    for (size_t a = 0; form_ == OptionForm::kBox && a < 3; ++a)
      wholes[a + 3] = std::max(wholes[a + 3], wholes[a] + 1);
  }
  void operator()(std::vector<OptionReals>& lists) {
    for (size_t i = 0; i < lists.size(); ++i) {
      OptionReals& list = lists[i];
      const OptionReals before = list;
      for (double& number : list) (*this)(number);
      // Points stay in ascending order, as their option demands.
      if (form_ == OptionForm::kPoints && i > 0) list[0] = std::max(list[0], lists[i - 1][0]);
      // Half way between two opposite normals there is none.
      if (form_ == OptionForm::kPlanes && length(Vec3d{list[0], list[1], list[2]}) < 1e-6)
        list = before;
    }
  }
  void operator()(std::vector<std::string>& texts) {
    for (std::string& text : texts) {
      if (form_ == OptionForm::kSurfaces) surface(text);
      if (form_ == OptionForm::kLabels) label(text);
      if (form_ == OptionForm::kChannels) channel(text);
    }
  }

 private:
  void visit(std::optional<double>& number) {
    const size_t at = found_.numbers.size();
    found_.numbers.push_back(number);
    // An automatic number stays automatic, since it has nothing to go on from.
    if (given_ != nullptr && number && (*given_)[at]) number = (*given_)[at];
  }
  void surface(std::string& text) {
    std::optional<SurfaceLook> look = parseSurfaceLook(text);
    if (!look) return;
    (*this)(look->value);
    (*this)(look->opacity);
    text = surfaceLookText(*look);
  }
  void label(std::string& text) {
    std::optional<LabelLook> look = parseLabelLook(text);
    if (!look) return;
    found_.names.push_back(labelLookText({look->first, look->last, {}, {}}));
    visit(look->opacity);
    text = labelLookText(*look);
  }
  void channel(std::string& text) {
    std::optional<ChannelLook> look = parseChannelLook(text);
    if (!look) return;
    found_.names.push_back(look->channel);
    const std::optional<ValueRange> before = look->range;
    std::optional<double> lo, hi;
    if (before) lo = before->lo, hi = before->hi;
    visit(lo);
    visit(hi);
    if (before && *lo != *hi) look->range = ValueRange{*lo, *hi};
    visit(look->opacity);
    text = channelLookText(*look);
  }

  const OptionForm form_;
  const Numbers* const given_;
  OptionNumbers found_;
};

}  // namespace

OptionNumbers optionNumbers(const OptionKind& kind, const OptionValue& value) {
  OptionValue copy = value;
  Visitor visitor(kind, nullptr);
  std::visit(visitor, copy);
  return visitor.found();
}

OptionValue withNumbers(const OptionKind& kind, OptionValue value, const Numbers& numbers) {
  Visitor visitor(kind, &numbers);
  std::visit(visitor, value);
  return value;
}

}  // namespace sluice

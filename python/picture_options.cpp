#include "python/picture_options.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <functional>
#include <map>
#include <sstream>
#include <string_view>
#include <utility>

#include "python/keyword_rules.h"
#include "src/base/field_names.h"
#include "src/options/option_rules.h"
#include "src/options/option_table.h"
#include "src/view/state/view_check.h"

namespace sluice::python {
namespace {

std::string printed(const py::handle& value) {
  return py::repr(value).cast<std::string>();
}

[[noreturn]] void failType(const std::string& keyword, std::string_view expected,
                           const py::handle& found) {
  throw py::type_error(fmt::format("{}: expected {}, found {}", keyword, expected, printed(found)));
}

[[noreturn]] void failValue(const std::string& keyword, std::string_view expected,
                            std::string_view found) {
  throw py::value_error(fmt::format("{}: expected {}, found {}", keyword, expected, found));
}

// `value` as a T. Python's own conversions apply: an int is a float, a NumPy scalar is a number.
template <class T>
T taken(const std::string& keyword, std::string_view expected, const py::handle& value) {
  try {
    return value.cast<T>();
  } catch (const py::cast_error&) {
    failType(keyword, expected, value);
  }
}

// "RRGGBB", with "#" or not, or three numbers from 0 to 1.
OptionReals colorOf(const std::string& keyword, const py::handle& value) {
  constexpr const char* kExpected = "'RRGGBB' or three numbers from 0 to 1";
  if (!py::isinstance<py::str>(value)) return taken<OptionReals>(keyword, kExpected, value);
  auto word = value.cast<std::string>();
  if (word.starts_with('#')) word.erase(0, 1);
  const bool is_hex =
      word.size() == 6 && word.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
  if (!is_hex) failValue(keyword, kExpected, printed(value));
  const unsigned long bits = std::stoul(word, nullptr, 16);
  return {static_cast<double>(bits >> 16) / 255, static_cast<double>(bits >> 8 & 255) / 255,
          static_cast<double>(bits & 255) / 255};
}

// Whether True and False stand for two of the words, as in shade=True.
bool isSwitch(const auto& entry) {
  return std::ranges::find(entry.kind.words, "on") != entry.kind.words.end();
}

std::string wordOf(const auto& entry, const std::string& keyword, const py::handle& value) {
  const auto& words = entry.kind.words;
  const std::string expected = fmt::format("one of '{}'", fmt::join(words, "', '"));
  if (isSwitch(entry) && py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "on" : "off";
  auto word = taken<std::string>(keyword, expected, value);
  if (const auto meant = entry.kind.meant) word = meant(word).value_or(word);
  if (std::find(words.begin(), words.end(), word) == words.end())
    failValue(keyword, expected, printed(value));
  return word;
}

// A list of as many numbers as the form has.
template <class List>
List listOf(const auto& entry, const std::string& keyword, const py::handle& value) {
  const size_t count = numbersOf(entry.kind.form);
  constexpr bool kWhole = std::is_same_v<List, OptionWholes>;
  // A command line may add the number of time steps, which is another keyword here.
  const std::string_view form = entry.value.substr(0, entry.value.find('['));
  const std::string expected =
      fmt::format("{}{} numbers ({})", count, kWhole ? " whole" : "", form);
  auto list = taken<List>(keyword, expected, value);
  if (list.size() != count) failValue(keyword, expected, printed(value));
  return list;
}

// A list of lists; points are also a dict from value to opacity.
std::vector<OptionReals> listsOf(const auto& entry, const std::string& keyword,
                                 const py::handle& value) {
  std::vector<OptionReals> lists;
  const py::object items = py::isinstance<py::dict>(value)
                               ? value.attr("items")()
                               : py::reinterpret_borrow<py::object>(value);
  for (const py::handle& item : taken<py::iterable>(keyword, "a list", items))
    lists.push_back(listOf<OptionReals>(entry, keyword, item));
  return lists;
}

// A number, a text of the command line, or a tuple of these as the command line has them.
std::string surfaceOf(const std::string& keyword, const py::handle& item) {
  if (py::isinstance<py::str>(item)) return item.cast<std::string>();
  if (!py::isinstance<py::tuple>(item))
    return fmt::format("{}",
                       taken<double>(keyword, "values, or (value, opacity, colour) each", item));
  std::string text;
  for (const py::handle& part : item)
    text += (text.empty() ? "" : ":") + py::str(part).cast<std::string>();
  return text;
}

// Surfaces: one or a list of them, a dict from values to opacities or (opacity, colour), or a text
// of the command line.
std::vector<std::string> surfacesOf(const std::string& keyword, const py::handle& value) {
  std::vector<std::string> texts;
  if (py::isinstance<py::str>(value)) {
    std::istringstream whole(value.cast<std::string>());
    for (std::string text; std::getline(whole, text, ',');) texts.push_back(text);
  } else if (py::isinstance<py::float_>(value) || py::isinstance<py::int_>(value)) {
    texts.push_back(surfaceOf(keyword, value));
  } else if (py::isinstance<py::dict>(value)) {
    for (const auto& [level, look] : py::reinterpret_borrow<py::dict>(value))
      texts.push_back(surfaceOf(keyword, level) + ":" + surfaceOf(keyword, look));
  } else {
    for (const py::handle& item :
         taken<py::iterable>(keyword, "values, or (value, opacity, colour) each", value))
      texts.push_back(surfaceOf(keyword, item));
  }
  return texts;
}

// Looks of labels, as a dict from labels to looks, or a list of texts of the command line.
std::vector<std::string> labelsOf(const std::string& keyword, const py::handle& value) {
  constexpr const char* kExpected = "looks of labels, such as {3: 'ff8800:0.4'}";
  if (py::isinstance<py::str>(value)) return {value.cast<std::string>()};
  if (!py::isinstance<py::dict>(value))
    return taken<std::vector<std::string>>(keyword, kExpected, value);
  std::vector<std::string> texts;
  for (const auto& [label, look] : py::reinterpret_borrow<py::dict>(value))
    texts.push_back(py::str(label).cast<std::string>() + "=" + py::str(look).cast<std::string>());
  return texts;
}

/// A function of the package's own checks, so that both sides read sizes and names alike.
py::object pythonsCheck(const char* name) {
  return py::module_::import("sluice._arguments").attr(name);
}

OptionValue valueOf(const auto& entry, const std::string& keyword, const py::handle& value) {
  switch (entry.kind.form) {
    case OptionForm::kFlag:
      if (!entry.kind.words.empty()) return wordOf(entry, keyword, value) == entry.kind.words[1];
      return taken<bool>(keyword, "True or False", value);
    case OptionForm::kBytes:
      if (py::isinstance<py::str>(value))
        return pythonsCheck("byte_count")(value, keyword).cast<int64_t>();
      return taken<int64_t>(keyword, entry.kind.noun, value);
    case OptionForm::kWhole:
      return taken<int64_t>(keyword, "a whole number", value);
    case OptionForm::kNumber:
    case OptionForm::kSeconds:
      return taken<double>(keyword, entry.kind.noun, value);
    case OptionForm::kWord:
      return wordOf(entry, keyword, value);
    case OptionForm::kChannel:
      if (!py::isinstance<py::str>(value))
        return taken<int64_t>(keyword, "a whole number or a name", value);
      [[fallthrough]];
    case OptionForm::kText:
    case OptionForm::kName:
      return taken<std::string>(keyword, "a text", value);
    case OptionForm::kFile:
      return pythonsCheck("file_name")(keyword, value).cast<std::string>();
    case OptionForm::kColor: {
      OptionReals color = colorOf(keyword, value);
      if (color.size() != 3) failValue(keyword, "three numbers from 0 to 1", printed(value));
      return color;
    }
    case OptionForm::kVoxel:
    case OptionForm::kDims:
    case OptionForm::kBox:
      return listOf<OptionWholes>(entry, keyword, value);
    case OptionForm::kChannels:
      if (py::isinstance<py::str>(value))
        return std::vector<std::string>{value.cast<std::string>()};
      return taken<std::vector<std::string>>(
          keyword, "looks of channels, such as ['0:green,400:3000']", value);
    case OptionForm::kLabels:
      return labelsOf(keyword, value);
    case OptionForm::kSurfaces:
      return surfacesOf(keyword, value);
    case OptionForm::kPoints:
    case OptionForm::kPlanes:
      return listsOf(entry, keyword, value);
    case OptionForm::kRange:
    case OptionForm::kAngles:
    case OptionForm::kPlace:
    case OptionForm::kDirection:
    case OptionForm::kSpacing:
      return listOf<OptionReals>(entry, keyword, value);
  }
  failType(keyword, "a value", value);
}

template <class Subject>
void take(const EntryOf<Subject>& entry, const py::handle& value, Subject& subject) {
  const std::string keyword = keywordOf(entry);
  const OptionValue taken_value = valueOf(entry, keyword, value);
  if (const auto fault = faultOf(entry.kind, taken_value))
    failValue(keyword, fault->expected, fault->found);
  entry.set(subject, taken_value);
}

// The type of an option's values for type checkers, in the words of __init__.pyi.
std::string typeOf(const auto& entry) {
  switch (entry.kind.form) {
    case OptionForm::kFlag:
      if (entry.kind.words.empty()) return "bool";
      [[fallthrough]];
    case OptionForm::kWord:
      if (entry.kind.meant != nullptr) return "str";
      return fmt::format("{}Literal['{}']", isSwitch(entry) ? "bool | " : "",
                         fmt::join(entry.kind.words, "', '"));
    case OptionForm::kWhole:
      return "int";
    case OptionForm::kBytes:
      return "int | str";
    case OptionForm::kNumber:
    case OptionForm::kSeconds:
      return "float";
    case OptionForm::kText:
    case OptionForm::kName:
      return "str";
    case OptionForm::kChannel:
      return "int | str | Sequence[int | str]";
    case OptionForm::kFile:
      return "_Path";
    case OptionForm::kColor:
      return "str | _Triple";
    case OptionForm::kVoxel:
    case OptionForm::kDims:
    case OptionForm::kBox:
      return "Sequence[int]";
    case OptionForm::kChannels:
      return "Sequence[str]";
    case OptionForm::kLabels:
      return "Mapping[int | str, str] | Sequence[str] | str";
    case OptionForm::kSurfaces:
      return "float | str | Mapping[float, Any] | Sequence[float | str | tuple[Any, ...]]";
    case OptionForm::kPoints:
      return "Mapping[float, float] | Sequence[Sequence[float]]";
    case OptionForm::kPlanes:
      return "Sequence[Sequence[float]]";
    case OptionForm::kAngles:
      return "tuple[float, float]";
    case OptionForm::kRange:
      return "Sequence[float]";
    case OptionForm::kPlace:
    case OptionForm::kDirection:
    case OptionForm::kSpacing:
      return "_Triple";
  }
  return "Any";
}

// An option of a picture that the table of options does not have.
struct PictureKeyword {
  std::string type;  // see KeywordType
  std::function<void(PictureOptions&, const py::handle&)> set;
};

void setSize(PictureOptions& picture, const py::handle& value) {
  constexpr const char* kExpected = "(width, height) or one number for both, each from 1";
  std::array<int, 2> size{};
  // NumPy's whole numbers are none of Python's.
  if (PyIndex_Check(value.ptr()) != 0) {
    size.fill(taken<int>("size", kExpected, value));
  } else {
    size = taken<std::array<int, 2>>("size", kExpected, value);
  }
  for (const int side : size)
    if (side < 1 || side > 1 << 30) failValue("size", kExpected, printed(value));
  picture.width = size[0];
  picture.height = size[1];
}

const std::map<std::string, PictureKeyword>& pictureOnlyKeywords() {
  static const std::map<std::string, PictureKeyword> keywords{
      {"size", {"int | tuple[int, int]", setSize}},
      {"modulate",
       {"bool",  // see modulate()
        [](PictureOptions&, const py::handle& value) {
          taken<bool>("modulate", "True or False", value);
        }}},
      {"depth",
       {"",
        [](PictureOptions& picture, const py::handle& value) {
          picture.with_depth = taken<bool>("depth", "True or False", value);
        }}},
  };
  return keywords;
}

const OptionEntry* entryOf(const std::string& keyword) {
  for (const OptionEntry& entry : optionTable())
    if (!entry.option.empty() && keywordOf(entry) == keyword) return &entry;
  return nullptr;
}

// The command line has a flag for the ramp over gradients and an option for where it ends; the
// state has its end alone.
void modulate(const py::kwargs& keywords, LookOptions& look) {
  const bool is_on = keywords.contains("modulate") && !keywords["modulate"].is_none() &&
                     keywords["modulate"].cast<bool>();
  if (is_on && !look.full_gradient) look.full_gradient = LookOptions::kUsualFullGradient;
}

void requireNoFault(const std::optional<ViewFault>& fault) {
  if (!fault) return;
  std::string keyword = fault->field.substr(fault->field.rfind('/') + 1);
  for (const OptionEntry& entry : optionTable())
    if (fault->field.find(std::string("/") + entry.key) != std::string::npos &&
        !entry.option.empty())
      keyword = keywordOf(entry);
  failValue(keyword, fault->expected, fault->found);
}

}  // namespace

AskedPicture askedPicture(const py::kwargs& keywords, const VolumeInfo& volume) {
  ViewState state;
  for (const auto& [name, value] : keywords) {
    const auto keyword = name.cast<std::string>();
    const auto own = pictureOnlyKeywords().find(keyword);
    const OptionEntry* const entry = entryOf(keyword);
    if (own == pictureOnlyKeywords().end() && entry == nullptr)
      throw py::type_error(fmt::format("unexpected keyword '{}'; there are: {}", keyword,
                                       fmt::join(pictureKeywords(), ", ")));
    if (value.is_none()) continue;
    if (entry == nullptr) {
      own->second.set(state, value);
      continue;
    }
    take(*entry, value, state);
  }
  requirePairs(keywords);
  modulate(keywords, state.look);
  requireNoFault(faultOf(state));
  requireNoFault(faultOf(state, volume));
  requireNoConflict(state);
  return {state, state.look, state.background, givenOptions(keywords)};
}

void takeVolumeKeywords(const py::dict& keywords, VolumeOptions& options) {
  for (const VolumeEntry& entry : volumeTable())
    if (const std::string keyword = keywordOf(entry); keywords.contains(keyword))
      if (const py::object value = keywords[keyword.c_str()]; !value.is_none())
        take(entry, value, options);
}

std::vector<KeywordType> volumeKeywordTypes() {
  std::vector<KeywordType> types;
  for (const VolumeEntry& entry : volumeTable())
    types.emplace_back(keywordOf(entry), typeOf(entry));
  return types;
}

std::vector<KeywordType> pictureKeywordTypes() {
  std::vector<KeywordType> types;
  for (const auto& [keyword, own] : pictureOnlyKeywords()) types.emplace_back(keyword, own.type);
  for (const OptionEntry& entry : optionTable())
    if (!entry.option.empty()) types.emplace_back(keywordOf(entry), typeOf(entry));
  return types;
}

std::vector<std::string> pictureKeywords() {
  std::vector<std::string> keywords;
  for (const auto& [keyword, type] : pictureKeywordTypes()) keywords.push_back(keyword);
  return keywords;
}

}  // namespace sluice::python

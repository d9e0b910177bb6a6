#include "io/hdf5/bdv_xml.h"

#include <algorithm>
#include <map>
#include <utility>

#include "io/files/length_unit.h"
#include "io/headers/header_fields.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kMostTextBytes = 64 << 10, kMostSetups = 10'000, kMostMissing = 1'000'000;
constexpr int64_t kMostTimes = 1'000'000;

BdvAffine product(const BdvAffine& a, const BdvAffine& b) {
  BdvAffine c{};
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 4; ++column) {
      c[4 * row + column] = column == 3 ? a[4 * row + 3] : 0;
      for (size_t i = 0; i < 3; ++i) c[4 * row + column] += a[4 * row + i] * b[4 * i + column];
    }
  return c;
}

class BdvParser {
 public:
  BdvParser(const ByteInput& input, const std::string& path) : input_(input), path_(path) {}

  BdvImage parse() {
    scanXml(input_, path_,
            {.begin = [this](const XmlTag& tag) { return begin(tag); },
             .end = [this](std::string_view, uint64_t) { end(); },
             .text =
                 [this](std::string_view text) {
                   if (text_.size() + text.size() > kMostTextBytes)
                     fail("{}: expected texts of at most {} bytes, found a longer one", path_,
                          kMostTextBytes);
                   text_ += text;
                 }});
    if (image_.data.empty())
      fail("{}: expected an ImageLoader of bdv.hdf5 or bdv.n5, found {}", path_,
           image_.format.empty() ? "none" : inQuotes(image_.format));
    if (image_.setups.empty()) fail("{}: expected a ViewSetup, found none", path_);
    if (image_.times.empty()) image_.times = {0};
    std::sort(image_.times.begin(), image_.times.end());
    image_.times.erase(std::unique(image_.times.begin(), image_.times.end()), image_.times.end());
    for (BdvSetup& setup : image_.setups) place(setup);
    return std::move(image_);
  }

 private:
  int64_t whole(std::string_view text, const char* what) const {
    const auto value = parseInteger(trimmed(text));
    if (!value || *value < 0)
      fail("{}: expected a whole number as {}, found {}", path_, what, inQuotes(text));
    return *value;
  }

  // Set-up and time point.
  std::pair<int64_t, int64_t> viewOf(const XmlTag& tag) const {
    return {whole(tag.find("setup").value_or(""), "a setup"),
            whole(tag.find("timepoint").value_or(""), "a timepoint")};
  }

  bool isIn(std::string_view parent) const {
    return open_.size() > 1 && open_[open_.size() - 2] == parent;
  }

  bool begin(const XmlTag& tag) {
    text_.clear();
    open_.emplace_back(tag.name);
    if (open_.size() == 1 && tag.name != "SpimData")
      fail("{}: expected BigDataViewer's SpimData, found {}", path_, inQuotes(tag.name));
    if (tag.name == "ImageLoader") image_.format = tag.find("format").value_or("");
    if (tag.name == "ViewSetup" && isIn("ViewSetups")) {
      if (image_.setups.size() == kMostSetups)
        fail("{}: expected at most {} set-ups, found more", path_, kMostSetups);
      image_.setups.emplace_back();
    }
    if (tag.name == "MissingView") {
      if (image_.missing_views.size() == kMostMissing)
        fail("{}: expected at most {} missing views, found more", path_, kMostMissing);
      const auto [setup, time] = viewOf(tag);
      image_.missing_views.emplace(time, setup);
    }
    if (tag.name == "ViewRegistration") {
      registration_ = viewOf(tag);
      affine_ = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    }
    return true;
  }

  void addTimes(int64_t first, int64_t last, int64_t step) {
    if (step < 1 || last < first || (last - first) / step >= kMostTimes)
      fail("{}: expected 1 to {} time points, found {} to {}", path_, kMostTimes, first, last);
    // Counted, since a time beyond the last one may not fit into the type.
    const int64_t count = (last - first) / step + 1;
    for (int64_t i = 0; i < count; ++i) image_.times.push_back(first + i * step);
    if (static_cast<int64_t>(image_.times.size()) > kMostTimes)
      fail("{}: expected at most {} time points, found more", path_, kMostTimes);
  }

  // "0-3, 5, 10-20:2"
  void addPattern(std::string_view pattern) {
    while (!trimmed(pattern).empty()) {
      const size_t comma = std::min(pattern.find(','), pattern.size());
      std::string_view part = trimmed(pattern.substr(0, comma));
      pattern.remove_prefix(std::min(comma + 1, pattern.size()));
      int64_t step = 1;
      if (const size_t colon = part.find(':'); colon != part.npos) {
        step = whole(part.substr(colon + 1), "a step of time points");
        part = part.substr(0, colon);
      }
      const size_t dash = part.find('-');
      const int64_t first = whole(part.substr(0, dash), "a time point");
      addTimes(first, dash == part.npos ? first : whole(part.substr(dash + 1), "a time point"),
               step);
    }
  }

  void end() {
    const std::string name = open_.back();
    const std::string_view text = trimmed(text_);
    const bool is_setup = isIn("ViewSetup") && !image_.setups.empty();
    if ((name == "hdf5" || name == "n5") && isIn("ImageLoader") &&
        (image_.format == "bdv.hdf5" || image_.format == "bdv.n5"))
      image_.data = text;
    if (name == "id" && is_setup) image_.setups.back().id = whole(text, "the id of a set-up");
    if (name == "name" && is_setup) image_.setups.back().name = text;
    if (name == "unit" && isIn("voxelSize") && !image_.setups.empty())
      image_.setups.back().unit = lengthUnit(text);
    if (name == "first" && isIn("Timepoints")) first_time_ = whole(text, "the first time point");
    if (name == "last" && isIn("Timepoints"))
      addTimes(first_time_, whole(text, "the last time point"), 1);
    if (name == "integerpattern" && isIn("Timepoints")) addPattern(text);
    if (name == "id" && isIn("Timepoint")) {
      const int64_t time = whole(text, "a time point");
      addTimes(time, time, 1);
    }
    if (name == "affine") {
      const std::vector<std::string_view> words = splitWords(text);
      BdvAffine affine{};
      for (size_t i = 0; i < affine.size(); ++i) {
        const auto value = words.size() == affine.size() ? parseReal(words[i]) : std::nullopt;
        if (!value)
          fail("{}: expected 12 numbers of an affine transform, found {}", path_, inQuotes(text));
        affine[i] = *value;
      }
      // The first transform that is listed is applied last.
      affine_ = product(affine_, affine);
    }
    if (name == "ViewRegistration") registrations_[registration_] = affine_;
    text_.clear();
    open_.pop_back();
  }

  void place(BdvSetup& setup) const {
    const auto first = registrations_.find({setup.id, image_.times[0]});
    if (first == registrations_.end()) return;
    setup.world = first->second;
    for (const int64_t time : image_.times) {
      const auto other = registrations_.find({setup.id, time});
      setup.has_moved |= other != registrations_.end() && other->second != setup.world;
    }
  }

  const ByteInput& input_;
  const std::string& path_;
  BdvImage image_;
  std::vector<std::string> open_;  // elements, the innermost last
  std::string text_;
  int64_t first_time_ = 0;
  BdvAffine affine_{};                        // of the registration that is open
  std::pair<int64_t, int64_t> registration_;  // set-up and time point
  std::map<std::pair<int64_t, int64_t>, BdvAffine> registrations_;
};

}  // namespace

bool isBdvXml(std::string_view head) {
  return head.find("<SpimData") != std::string_view::npos;
}

BdvImage parseBdvXml(const ByteInput& input, const std::string& path) {
  return BdvParser(input, path).parse();
}

}  // namespace sluice

// Every option of a view or a volume survives a saved view and a command line: values at random for
// each entry of the table, with a seed, there and back.
#include "src/options/option_table.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "src/view/state/files/state_file.h"
#include "src/view/state/printed_command.h"
#include "src/view/state/view_check.h"
#include "tools/options/shared_options.h"
#include "tools/options/view_arguments.h"

namespace sluice {
namespace {

// Values that an option takes, of every form.
class Values {
 public:
  OptionValue of(const OptionKind& kind) {
    switch (kind.form) {
      case OptionForm::kFlag:
        return true;
      case OptionForm::kWhole:
        return whole(static_cast<int64_t>(std::max(kind.limits.least, 0.0)),
                     kind.limits.most < 1000 ? static_cast<int64_t>(kind.limits.most) : 1000);
      case OptionForm::kBytes:
        return whole(1, int64_t{1} << 62);
      case OptionForm::kNumber:
      case OptionForm::kSeconds:
        return number(std::max(kind.limits.least, -1e7), std::min(kind.limits.most, 1e7));
      case OptionForm::kWord:
        return std::string(kind.words[static_cast<size_t>(whole(0, 99)) % kind.words.size()]);
      case OptionForm::kText:
        return std::string(whole(0, 1) == 0 ? "viridis" : "c0ffee");  // colours are the only texts
      case OptionForm::kFile:
        return std::string(whole(0, 1) == 0 ? "no such file.json" : "b.json");
      case OptionForm::kName:
        return std::string("caf\xe9 '3'");
      case OptionForm::kChannel:
        if (whole(0, 1) == 0) return std::string("0,DAPI \xff");
        return whole(0, static_cast<int64_t>(kind.limits.most));
      case OptionForm::kRange:
        return numbers(2);
      case OptionForm::kPlace:
      case OptionForm::kDirection:
        return numbers(3);
      case OptionForm::kColor:
        return OptionReals{channel(), channel(), channel()};
      case OptionForm::kSpacing:
        return OptionReals{number(1e-9, 1), number(1, 1e3), number(1e3, kind.limits.most)};
      case OptionForm::kVoxel:
        return OptionWholes{whole(0, 99), whole(0, 99), whole(0, 99)};
      case OptionForm::kDims: {
        const OptionWholes dims{whole(1, 99), whole(1, 99), whole(1, int64_t{1} << 40)};
        return whole(0, 1) == 0 ? dims : OptionWholes{dims[0], dims[1], dims[2], whole(1, 99)};
      }
      case OptionForm::kBox: {
        const OptionWholes lo{whole(0, 99), whole(0, 99), whole(0, int64_t{1} << 39)};
        return OptionWholes{lo[0], lo[1], lo[2], lo[0] + 2, lo[1] + whole(2, 9), lo[2] + 5};
      }
      case OptionForm::kPoints: {
        const double first = number(-9, 9);
        return std::vector<OptionReals>{{first, number(0, 1)}, {first + number(0, 1), 1}};
      }
      case OptionForm::kChannels:
        return std::vector<std::string>{"0:green,400:3000", "DAPI:0000ff,-1:2.5,0.125"};
      case OptionForm::kAngles:
        return OptionReals{number(kind.limits.least, kind.limits.most),
                           number(kind.limits.least, kind.limits.most)};
      case OptionForm::kSurfaces:
        return std::vector<std::string>{"300:0.4:green", "-1.5"};
      case OptionForm::kLabels:
        return std::vector<std::string>{"3=ff8800:0.4", "7-9=:0"};
      case OptionForm::kPlanes:
        break;
    }
    return std::vector<OptionReals>(static_cast<size_t>(whole(1, 6)), numbers(4));
  }

 private:
  int64_t whole(int64_t least, int64_t most) {
    return std::uniform_int_distribution<int64_t>(least, most)(random_);
  }
  double number(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  OptionReals numbers(size_t count) {
    OptionReals found;
    for (size_t i = 0; i < count; ++i) found.push_back(number(-1e4, 1e4));
    return found;
  }
  // A channel of a colour that a command line can say.
  double channel() { return static_cast<float>(static_cast<double>(whole(0, 255)) / 255); }

  std::mt19937_64 random_{1};
};

// A view that is saved and printed with the entry's value.
ViewState viewWith(const OptionEntry& entry, Values& values) {
  ViewState state;
  state.view.projection = ViewOptions::Projection::kPerspective;
  if (std::string_view(entry.key) == "eye" || std::string_view(entry.key) == "target")
    state.view.look_at = ViewOptions::LookAt{{1, 2, 3}, {-4, 5, 6}};
  // A command line with looks of labels means labels.
  state.look.labels = std::string_view(entry.key).starts_with("label_");
  if (entry.option == "--attenuation") state.look.mode = LookOptions::Mode::kAttenuatedMaximum;
  entry.set(state, values.of(entry.kind));
  return state;
}

// The view, or volume, that the options of `sluice render` ask for.
ViewState parsed(const std::vector<OptionWord>& words, VolumeArguments& volume) {
  LookArguments look;
  FrameOptions frame;
  FitChoice fit;
  CLI::App app;
  addVolumeOptions(app, volume, nullptr, false);
  addOverOption(app, volume);
  ResourceArguments resources;
  const AskedView asked = addPictureOptions(app, look, frame, fit);
  addFrameOptions(app, asked, frame);
  addTimeLimit(app, asked, frame);
  addLevelOptions(app, asked, frame, resources);
  std::vector<std::string> given;
  for (const auto& [option, value] : words)
    given.push_back(value.empty() ? option : option + "=" + value);
  std::reverse(given.begin(), given.end());
  app.parse(given);
  return viewState(*asked, volume, look);
}
ViewState parsed(const std::vector<OptionWord>& words) {
  VolumeArguments volume;
  return parsed(words, volume);
}

// The values that the table of options holds of a volume.
std::vector<std::optional<OptionValue>> valuesOf(const VolumeOptions& options) {
  std::vector<std::optional<OptionValue>> values;
  for (const VolumeEntry& entry : volumeTable()) values.push_back(entry.get(options));
  return values;
}

TEST(OptionTable, everyOptionSurvivesASavedView) {
  Values values;
  for (const OptionEntry& entry : optionTable())
    for (int i = 0; i < 20 && entry.part != OptionPart::kPicture; ++i) {
      const ViewState state = viewWith(entry, values);
      const std::string text = stateText({}, state);
      EXPECT_EQ(parseState(text, "here").state, state) << text;
    }
}

TEST(OptionTable, everyOptionOfAVolumeSurvivesASavedViewAndACommandLine) {
  Values values;
  for (const VolumeEntry& entry : volumeTable())
    for (int i = 0; i < 20; ++i) {
      ViewedVolume volume{{"a.raw"}, {}};
      volume.options.dims = {4, 5, 6};  // time_steps needs them
      const OptionValue value = values.of(entry.kind);
      entry.set(volume.options, value);
      EXPECT_EQ(entry.get(volume.options), value) << entry.key;
      const std::string text = stateText(volume, {});
      EXPECT_EQ(valuesOf(parseState(text, "here").volume->options), valuesOf(volume.options))
          << text;
      VolumeArguments arguments;
      parsed(volumeWords(volume.options), arguments);
      EXPECT_EQ(valuesOf(arguments.asked), valuesOf(volume.options)) << entry.key;
    }
}

// The options of one picture alone, which views are printed without.
std::vector<OptionWord> wordsOfPicture(const OptionEntry& entry, const ViewState& state) {
  if (entry.part != OptionPart::kPicture) return {};
  const OptionValue value = entry.get(state).value();
  if (std::holds_alternative<bool>(value)) return {{std::string(entry.option), ""}};
  const auto* const whole = std::get_if<int64_t>(&value);
  return {{std::string(entry.option), whole != nullptr
                                          ? fmt::format("{}", *whole)
                                          : fmt::format("{}", std::get<double>(value))}};
}

TEST(OptionTable, everyOptionSurvivesACommandLine) {
  Values values;
  for (const OptionEntry& entry : optionTable())
    for (int i = 0; i < 20 && !entry.option.empty(); ++i) {
      const ViewState state = viewWith(entry, values);
      std::vector<OptionWord> words = pictureWords(state);
      for (const OptionWord& word : lookWords(state.look)) words.push_back(word);
      for (const OptionWord& word : wordsOfPicture(entry, state)) words.push_back(word);
      EXPECT_EQ(parsed(words), state) << entry.key;
    }
}

TEST(OptionTable, viewsAreSavedAndPrintedWithoutOptionsOfOnePicture) {
  Values values;
  for (const OptionEntry& entry : optionTable()) {
    if (entry.part != OptionPart::kPicture) continue;
    const ViewState state = viewWith(entry, values);
    ViewState plain;
    plain.view.projection = state.view.projection;
    EXPECT_NE(state, plain);
    EXPECT_EQ(stateText({}, state), stateText({}, plain)) << entry.key;
    EXPECT_EQ(pictureWords(state), pictureWords(plain)) << entry.key;
  }
}

}  // namespace
}  // namespace sluice

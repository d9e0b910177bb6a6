#include "tools/command_line/usage.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <set>

#include "tools/command_line/help.h"
#include "tools/command_line/near_miss.h"
#include "tools/command_line/option_group.h"

namespace sluice {
namespace {

const auto kAll = [](const CLI::App*) { return true; };

std::vector<std::string> commandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(kAll)) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> optionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string unknownCommand(const CLI::App& app, const std::string& word) {
  const std::vector<std::string> known = commandNames(app);
  std::error_code ignored;
  if (app.get_parent() == nullptr &&
      (std::filesystem::exists(word, ignored) || word.starts_with("synth:")))
    return fmt::format("expected a command before {}; did you mean {} render {} -o picture.png?",
                       word, fullName(app), word);
  const std::string meant = nearest(word, known);
  if (!meant.empty())
    return fmt::format("there is no command '{}'; did you mean {} {}?", word, fullName(app), meant);
  return fmt::format("there is no command '{}'; {} has {}", word, fullName(app), listed(known));
}

// The commands other than `app` that have an option of this name.
std::vector<std::string> commandsWith(const CLI::App& app, const std::string& name) {
  std::vector<std::string> found;
  for (const CLI::App* command : app.get_subcommands(kAll)) {
    if (command->get_option_no_throw(name) != nullptr) found.push_back(command->get_name());
  }
  return found;
}

std::string unknownOption(const CLI::App& program, const CLI::App& app, const std::string& name) {
  const std::string line = fmt::format("{} has no option {}", fullName(app), name);
  const auto others = commandsWith(program, name);
  const std::string meant = nearest(name, optionNames(app));
  if (others.empty() && !meant.empty()) return line + "; did you mean " + meant + "?";
  if (!others.empty())
    return line + "; " + listed(others) + (others.size() > 1 ? " have" : " has") + " it";
  return line + fmt::format(" (see {} --help)", fullName(app));
}

bool isLong(const std::string& word) {
  return word.size() > 2 && word.starts_with("--");
}
// "-5" and "-.5" are numbers.
bool isShort(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && word[1] != '-' && word[1] != '.' &&
         (word[1] < '0' || word[1] > '9');
}

// Walks over the words as the parser will.
class Walk {
 public:
  Walk(const CLI::App& program, const std::vector<std::string>& words)
      : program_(program), app_(&program), words_(words) {}

  std::optional<std::string> fault() {
    for (; at_ < words_.size(); ++at_) {
      const std::string& word = words_[at_];
      // All words behind it are arguments, which the parser judges.
      if (word == "--") break;
      std::optional<std::string> found;
      if (isLong(word)) {
        found = atLong(word);
      } else if (isShort(word)) {
        found = atShort(word);
      } else {
        found = atWord(word);
      }
      // Help is printed whatever stands behind it.
      if (found || asks_help_) return found;
    }
    const auto commands = commandNames(*app_);
    if (commands.empty()) return std::nullopt;
    return fmt::format("{} needs a command: {}", fullName(*app_), listed(commands));
  }

 private:
  std::optional<std::string> atWord(const std::string& word) {
    if (app_->get_subcommands(kAll).empty()) return std::nullopt;
    const auto found =
        app_->get_subcommands([&](const CLI::App* command) { return command->get_name() == word; });
    if (found.empty()) return unknownCommand(*app_, word);
    app_ = found.front();
    return std::nullopt;
  }

  std::optional<std::string> atLong(const std::string& word) {
    const size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const CLI::Option* option = app_->get_option_no_throw(name);
    if (option == nullptr) return unknownOption(program_, *app_, name);
    if (equals != std::string::npos && option->get_disable_flag_override())
      return fmt::format("{}: expected no value, found '{}'", name, word.substr(equals + 1));
    if (equals + 1 == word.size())
      return fmt::format("{}: expected {} after the '='", name,
                         option->get_expected_max() == 0 ? "a value" : option->get_type_name());
    return take(*option, name, equals != std::string::npos);
  }

  // "-j4", "-qj4", "-o a.png"
  std::optional<std::string> atShort(const std::string& word) {
    for (size_t i = 1; i < word.size(); ++i) {
      const std::string name{'-', word[i]};
      const CLI::Option* option = app_->get_option_no_throw(name);
      if (option == nullptr) return unknownOption(program_, *app_, i == 1 ? word : name);
      const bool has_value = option->get_expected_max() != 0;
      auto found = take(*option, name, has_value && i + 1 < word.size());
      if (found || has_value) return found;
    }
    return std::nullopt;
  }

  std::optional<std::string> take(const CLI::Option& option, const std::string& name,
                                  bool value_attached) {
    asks_help_ = &option == app_->get_help_ptr() || &option == app_->get_help_all_ptr() ||
                 &option == app_->get_version_ptr();
    const bool takes_value = option.get_expected_max() != 0;
    if (takes_value || value_attached) with_value_.insert(&option);
    // Options with a trigger take a list, one word each time.
    if (++count_[&option] > 1 && with_value_.contains(&option) && !option.get_trigger_on_parse())
      return fmt::format("{} is given twice", name);
    if (!takes_value || value_attached) return std::nullopt;
    if (++at_ == words_.size())
      return fmt::format("{}: expected {} after it", name, option.get_type_name());
    return std::nullopt;
  }

  const CLI::App& program_;
  const CLI::App* app_;
  const std::vector<std::string>& words_;
  size_t at_ = 0;
  bool asks_help_ = false;
  std::map<const CLI::Option*, int> count_;
  std::set<const CLI::Option*> with_value_;  // `--shadows` may stand alone or have one
};

}  // namespace

std::optional<std::string> wrongUsage(const CLI::App& program,
                                      const std::vector<std::string>& words) {
  return Walk(program, words).fault();
}

}  // namespace sluice

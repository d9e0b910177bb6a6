// Options of a view or a volume on the command line, as the table of options describes them
// (src/options/option_table.h).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "src/options/option_table.h"
#include "src/options/view_state.h"
#include "tools/command_line/option_group.h"

namespace sluice {

// The view that a command's options ask for; the time step is not in it. Shared with the options,
// which fill it as they are parsed.
using AskedView = std::shared_ptr<ViewState>;

// `Subject`: ViewState or VolumeOptions.
template <class Subject>
class TableOptionsOf {
 public:
  using Take = std::function<void(const Subject&)>;

  // `app` must outlive the options. `take` gets the subject whenever an option has changed it.
  TableOptionsOf(CLI::App& app, std::shared_ptr<Subject> asked, Take take)
      : app_(app), asked_(std::move(asked)), take_(std::move(take)) {}

  // Adds an option. `names`: with a short name, if it has one. `shown`: the default in --help if
  // `asked` does not hold it. `heading`: instead of the table's.
  CLI::Option* add(const std::string& names, const std::string& shown = "",
                   const std::string& heading = "") const;
  // Adds the options of this heading and part that the command does not have yet.
  void addRest(std::string_view heading, OptionPart part) const;

 private:
  CLI::App& app_;
  const std::shared_ptr<Subject> asked_;
  const Take take_;
};
using TableOptions = TableOptionsOf<ViewState>;

// Lets the options of a command go together as option_rules.h says. To be called when the command
// has all of them.
void pairOptions(CLI::App& command);

}  // namespace sluice

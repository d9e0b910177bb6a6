// Options of a view on the command line, as the table of options describes them
// (src/options/option_table.h).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "src/options/view_state.h"
#include "tools/command_line/option_group.h"

namespace sluice {

// The view that a command's options ask for; the time step is not in it. Shared with the options,
// which fill it as they are parsed.
using AskedView = std::shared_ptr<ViewState>;

class TableOptions {
 public:
  // `app` must outlive the options.
  TableOptions(CLI::App& app, const std::string& heading, AskedView asked)
      : group_(app, heading), asked_(std::move(asked)) {}

  // Adds the option; once `asked` has its value, `take` is called. `names`: with a short name, if
  // it has one. `shown`: the default in --help if `asked` does not hold it.
  CLI::Option* add(const std::string& names, const std::function<void(const ViewState&)>& take,
                   const std::string& shown = "") const;

 private:
  const OptionGroup group_;
  const AskedView asked_;
};

}  // namespace sluice

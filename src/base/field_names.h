// The names of options in messages. Within the program a message names options as the command line
// has them; users of the public headers get the same line with the fields of those headers.
#pragma once

#include <sluice/error.h>

#include <functional>
#include <string>
#include <string_view>

namespace sluice {

// The line with another name for each option that it names, such as "--pixel-error". Advice about
// options that only the program has, as in " or fewer --pages", is left out.
std::string renamed(std::string_view line,
                    const std::function<std::string(std::string_view option)>& nameOf);

// An Error as it leaves the library: what() names fields (src/library/option_fields.h).
class FieldError : public Error {
 public:
  FieldError(const Error& error, const std::string& line_in_fields)
      : Error(line_in_fields, error.kind()), line_in_options_(error.what()) {}
  const std::string& lineInOptions() const { return line_in_options_; }

 private:
  std::string line_in_options_;
};

// An error's line with the options of the command line, for callers of the library that know them.
std::string lineInOptions(const std::exception& error);

}  // namespace sluice

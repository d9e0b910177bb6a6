// Exceptions of the library. In addition it throws those of the C++ library (std::bad_alloc).
#pragma once

#include <exception>
#include <stdexcept>
#include <string>

namespace sluice {

// Bad input, a bad environment or an impossible request. what() is one line for a person: which
// file (and block) or argument, what was expected, what was found, what to do. It names options by
// their fields in these headers.
class Error : public std::runtime_error {
 public:
  // The kind tells what has to change before the same call works.
  enum class Kind {
    kInput,    // the data: a file is missing, damaged, or of no known kind
    kRequest,  // the options, which this volume or device does not allow
    kMemory,   // the limit of memory, which is too small for them
    kSystem,   // the machine: a full disk, a driver, a library that is missing, the network
  };

  explicit Error(const std::string& line, Kind kind = Kind::kInput)
      : std::runtime_error(line), kind_(kind) {}
  Kind kind() const noexcept { return kind_; }

 private:
  Kind kind_;
};

// Work that was asked to stop and did: nothing is wrong, there is just no result. Not an Error, so
// that code which reports errors need not tell them apart.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

}  // namespace sluice

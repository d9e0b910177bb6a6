// Exceptions of the library. In addition it throws those of the C++ library (std::bad_alloc).
#pragma once

#include <exception>
#include <stdexcept>
#include <string>

namespace sluice {

// Bad input, a bad environment or an impossible request. what() is one line for a person: which
// file (and block) or argument, what was expected, what was found, what to do.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& line) : std::runtime_error(line) {}
};

// Work that was asked to stop and did: nothing is wrong, there is just no result. Not an Error, so
// that code which reports errors need not tell them apart.
class Cancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

}  // namespace sluice

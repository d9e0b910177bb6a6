// Interruption by SIGINT or SIGTERM: long loops ask, and unwind through their destructors, so that
// temporary files go and the program ends with status 130.
#pragma once

#include <exception>

namespace sluice {

class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

// Installs the handlers; a second signal ends the process at once. Called once, by main.
void watchForInterruption();
// Throws Interrupted once a signal has come. Cheap; call it once a block.
void throwIfInterrupted();

}  // namespace sluice

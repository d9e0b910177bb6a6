// SharedLibrary: a library opened at run time with its symbols kept to itself, and never closed:
// threads, exit handlers and objects of its making may outlive whoever opened it. Copies name the
// same library. Any thread.
#pragma once

#include <span>
#include <string>

namespace sluice {

class SharedLibrary {
 public:
  // Opens the first of `names` that opens. Throws Error: the system's message for the first one,
  // and `hint` (what to install).
  SharedLibrary(std::span<const std::string> names, const std::string& hint);

  // Returns null if the library has no such symbol.
  void* find(const char* symbol) const;
  // Throws Error when the library has no such symbol.
  template <class Function>
  Function get(const char* symbol) const {
    return reinterpret_cast<Function>(require(symbol));
  }

 private:
  void* require(const char* symbol) const;

  std::string name_;
  void* handle_ = nullptr;
};

}  // namespace sluice

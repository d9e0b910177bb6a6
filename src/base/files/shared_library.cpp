#include "src/base/files/shared_library.h"

#include <dlfcn.h>

#include "src/base/error.h"

namespace sluice {

SharedLibrary::SharedLibrary(std::span<const std::string> names, const std::string& hint) {
  std::string reason = "no name to look for";
  for (const std::string& name : names) {
    handle_ = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle_ != nullptr) {
      name_ = name;
      return;
    }
    const char* said = dlerror();
    if (&name == &names.front()) reason = said != nullptr ? said : name + ": does not open";
  }
  failSystem("{} ({})", reason, hint);
}

void* SharedLibrary::find(const char* symbol) const {
  return dlsym(handle_, symbol);
}

void* SharedLibrary::require(const char* symbol) const {
  void* const address = find(symbol);
  if (address == nullptr)
    failSystem("{}: has no function {}, is it the right library?", name_, symbol);
  return address;
}

}  // namespace sluice

// A window that makes an error of OpenGL and loses some memory now and then, for a program that is
// started with this library in LD_PRELOAD: that both are seen is tested with it.
#include <dlfcn.h>

#include <cstddef>
#include <cstdlib>

namespace {

template <class Function>
Function* real(const char* name) {
  void* const library = dlopen("libGL.so.1", RTLD_LAZY | RTLD_NOLOAD);
  void* const found = library != nullptr ? dlsym(library, name) : nullptr;
  if (found == nullptr) std::abort();
  return reinterpret_cast<Function*>(found);
}

}  // namespace

extern "C" void glClear(unsigned mask);
extern "C" void glClear(unsigned mask) {
  static auto* const clear = real<void(unsigned)>("glClear");
  static auto* const enable = real<void(unsigned)>("glEnable");
  clear(mask);
  constexpr unsigned kNothing = 0xFFFF;
  enable(kNothing);
  // Through a volatile pointer, so that the compiler does not see that it is lost.
  static void* (*volatile const take)(size_t) = std::malloc;
  static_cast<void>(take(100));
}

#include "src/base/sanitizer_options.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SLUICE_HAS_LEAK_SANITIZER
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define SLUICE_HAS_LEAK_SANITIZER
#endif

#ifdef SLUICE_HAS_LEAK_SANITIZER
// NOLINTBEGIN(bugprone-reserved-identifier): the names that the sanitizer looks for
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_options();

const char* __lsan_default_suppressions() {
  // Debian's Mesa has no symbols: its modules are named.
  return "leak:readTopology\n"
         "leak:libOSMesa.so\nleak:libEGL\nleak:swrast_dri.so\nleak:libgallium\nleak:libLLVM\n";
}
const char* __lsan_default_options() {
  return "print_suppressions=0";
}
// NOLINTEND(bugprone-reserved-identifier)
#endif

#ifdef __SANITIZE_THREAD__
// NOLINTBEGIN(bugprone-reserved-identifier): the name that the sanitizer looks for
extern "C" const char* __tsan_default_suppressions();

const char* __tsan_default_suppressions() {
  return "race:tbb::detail\n"
         "race:openvdb::v10_0\n"
         "called_from_lib:libtbb.so\n"
         "race:std::__exception_ptr\n"
         "race:std::runtime_error::~runtime_error\n"
         "race:sluice::Error::~Error\n";
}
// NOLINTEND(bugprone-reserved-identifier)
#endif

namespace sluice {

void linkSanitizerOptions() {}

}  // namespace sluice

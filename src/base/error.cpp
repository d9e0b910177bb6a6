#include "src/base/error.h"

#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "src/base/sanitizer_options.h"

namespace sluice {

void failErrno(const std::string& what, int error_number) {
  throw Error(fmt::format("{}: {}", what, std::generic_category().message(error_number)));
}

namespace internal {
void checkFailed(const char* file, int line, const char* condition, const std::string& values) {
  linkSanitizerOptions();
  std::fprintf(stderr, "%s:%d: check failed: %s %s\n", file, line, condition, values.c_str());
  std::abort();
}
}  // namespace internal
}  // namespace sluice

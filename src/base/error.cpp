#include "src/base/error.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "src/base/sanitizer_options.h"

namespace sluice {

Error::Kind kindOf(int error_number) {
  switch (error_number) {
    case ENOENT:
    case ENOTDIR:
    case EISDIR:
    case EACCES:
    case ELOOP:
    case ENAMETOOLONG:
      return Error::Kind::kInput;
    case ENOMEM:
      return Error::Kind::kMemory;
    default:
      return Error::Kind::kSystem;
  }
}

void failErrno(const std::string& what, int error_number) {
  failAs(kindOf(error_number), "{}: {}", what, std::generic_category().message(error_number));
}

namespace internal {
void checkFailed(const char* file, int line, const char* condition, const std::string& values) {
  linkSanitizerOptions();
  std::fprintf(stderr, "%s:%d: check failed: %s %s\n", file, line, condition, values.c_str());
  std::abort();
}
}  // namespace internal
}  // namespace sluice

#include "src/base/threads/kept_addresses.h"

#include <sys/mman.h>

namespace sluice {
namespace {

void* addresses(size_t bytes) {
  void* const at =
      mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return at == MAP_FAILED ? nullptr : at;
}

}  // namespace

KeptAddresses::KeptAddresses(size_t bytes) : bytes_(bytes), at_(addresses(bytes)) {}

KeptAddresses::~KeptAddresses() {
  if (at_ != nullptr) munmap(at_, bytes_);
}

}  // namespace sluice

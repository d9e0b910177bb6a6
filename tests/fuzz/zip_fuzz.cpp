#include <sys/mman.h>
#include <unistd.h>

#include <fmt/format.h>

#include "io/stores/zip_directory.h"
#include "src/base/error.h"
#include "src/base/files/descriptor.h"

// The list of files of a zip file: each key is found, in order, with bytes within the file.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sluice;
  const Descriptor made(memfd_create("a.zip", MFD_CLOEXEC));
  if (!made || write(made.get(), data, size) != static_cast<ssize_t>(size)) return 0;
  try {
    File file(fmt::format("/proc/self/fd/{}", made.get()));
    const ZipDirectory directory(file);
    for (size_t i = 0; i < directory.size(); ++i) {
      const ZipEntry entry = directory.at(i);
      SLUICE_CHECK(i == 0 || directory.at(i - 1).key < entry.key);
      SLUICE_CHECK(directory.find(entry.key).has_value());
      SLUICE_CHECK_LE(entry.header_at, size);
      SLUICE_CHECK_LE(entry.stored_bytes, size - entry.header_at);
    }
  } catch (const Error&) {
  }
  return 0;
}

#include "io/headers/raw/raw_name.h"
#include "src/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const sluice::RawName name = sluice::parseRawName(text);
  if (name.dims) SLUICE_CHECK(name.dims->x > 0 && name.dims->y > 0 && name.dims->z > 0);
  if (name.time_steps) SLUICE_CHECK(name.dims.has_value() && *name.time_steps > 0);
  return 0;
}

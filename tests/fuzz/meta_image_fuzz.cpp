#include "io/headers/meta_image/meta_image_header.h"
#include "tests/fuzz/description_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  sluice::checkParser([&] { return sluice::parseMetaImageHeader(text, "v.mha"); });
  sluice::metaImageHeaderComplete(text);
  return 0;
}

#include "io/headers/nifti/nifti_header.h"
#include "tests/fuzz/description_checks.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  sluice::checkParser([&] { return sluice::parseNiftiHeader(bytes, "v.nii").description; });
  return 0;
}

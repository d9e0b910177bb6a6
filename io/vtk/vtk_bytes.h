// The numbers of a VTK array as bytes at positions, without a copy of them in memory or on disk:
// base64 is decoded where it is read, and compressed blocks as they are needed.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "io/files/file.h"
#include "io/vtk/vtk_image.h"

namespace sluice {

struct VtkBytes {
  std::shared_ptr<ByteStore> store;
  uint64_t offset = 0;  // of the first number in the store
};

// `bytes`: of the array's numbers. Throws Error, which names the file and the array: the file is
// cut short, or says another size. Requires: the array is no text.
VtkBytes openVtkBytes(const std::shared_ptr<File>& file, const VtkImage& image,
                      const VtkArray& array, uint64_t bytes);

}  // namespace sluice

// The interface between the program and its module for HDF5.
//
// All that includes HDF5's headers is a library apart, sluice_hdf5.so, opened with the first file
// of that kind (src/base/files/program_module.h says where from). It tells where the chunks of a
// data set are and hands out their bytes as they are stored; the program decodes them, on any
// number of threads, while HDF5's library lets in one at a time.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/values/voxel_type.h"

namespace sluice {

// A step of what is done to a chunk before it is written.
struct Hdf5Filter {
  int number = 0;  // as registered with The HDF Group
  std::string name;
  std::vector<unsigned> values;
  bool is_in_library = false;  // the library can undo it
};

struct Hdf5Attribute {
  std::string name;
  std::vector<double> numbers;     // one of these two is empty
  std::vector<std::string> texts;  // each of bounded length
};

// A dimension scale of HDF5: the positions of the voxels along an axis.
struct Hdf5Scale {
  std::string path;            // of its data set; empty: the axis has none
  std::vector<double> values;  // one for each voxel; empty: it gives no positions
  std::vector<Hdf5Attribute> attributes;
};

struct Hdf5Description {
  std::vector<int64_t> shape;
  std::vector<int64_t> chunks;  // empty: it is not in chunks
  VoxelType type = VoxelType::kU8;
  std::endian byte_order = std::endian::little;
  double fill_value = 0;
  std::vector<Hdf5Filter> filters;      // in the order of writing
  std::optional<uint64_t> in_place_at;  // offset in the file of voxels in one piece
  std::vector<Hdf5Attribute> attributes;
  std::vector<Hdf5Scale> scales;  // of each axis; empty: none has one
};

// All members throw Error, which starts with the file's name. Any thread.
class Hdf5Set {
 public:
  virtual ~Hdf5Set() = default;
  virtual const Hdf5Description& description() const = 0;
  // Bytes of a chunk as it is stored; 0: there is none. `corner`: its first voxel.
  virtual uint64_t storedBytes(std::span<const int64_t> corner) = 0;
  // Reads as many. Returns the mask of filters that were left out.
  virtual uint32_t readStored(std::span<const int64_t> corner, std::span<std::byte> out) = 0;
  // Reads a box, decoded by the library, the last axis fastest, in the file's byte order.
  virtual void readBox(std::span<const int64_t> corner, std::span<const int64_t> extents,
                       std::span<std::byte> out) = 0;
};

struct Hdf5Entry {
  std::string path;
  std::vector<int64_t> shape;  // empty: not an array
};

class Hdf5File {
 public:
  virtual ~Hdf5File() = default;
  // The data sets of two axes or more, at most `most`, in the order of their names.
  virtual std::vector<Hdf5Entry> sets(size_t most) = 0;
  // True if there is a group or a data set of this name.
  virtual bool has(const std::string& path) = 0;
  // Throws Error: no data set, or of a kind that is not read.
  virtual std::unique_ptr<Hdf5Set> open(const std::string& path) = 0;
  // The attributes of a group or data set, of any name.
  virtual std::vector<Hdf5Attribute> attributes(const std::string& path) = 0;
};

// The one function of the module.
using OpenHdf5 = void(const std::string& path, std::shared_ptr<Hdf5File>& file);
inline constexpr const char* kOpenHdf5 = "sluiceOpenHdf5";

// The module exports this before anything is called: the version of sluice and of this interface.
inline constexpr const char* kOpenHdf5Version = "sluiceOpenHdf5Version";
inline constexpr const char* kHdf5ModuleVersion = SLUICE_VERSION " hdf5 module 2";

}  // namespace sluice

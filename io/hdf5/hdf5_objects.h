// Types, attributes and scales of HDF5's objects, for the module (hdf5_module.h) alone. Every
// function is called with the library's mutex held.
#pragma once

#include <hdf5.h>

#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/hdf5/hdf5_module.h"

namespace sluice {

// An identifier of the library, closed at the end.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close close) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle& operator=(Handle&&) = delete;
  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
  Close close_;
};

// The innermost reason that the library has for its last failure.
std::string reason();
// Nullopt: not the type of a voxel.
std::optional<VoxelType> voxelTypeOf(hid_t type);
// Words for the type of voxels that are not read.
std::string wordsOf(hid_t type);
std::endian orderOf(hid_t type);
std::vector<int64_t> extentsOf(std::span<const hsize_t> dims);
// The attributes of an object that are numbers or texts.
std::vector<Hdf5Attribute> readAttributes(hid_t object);
// The first scale of each axis (HDF5's dimension scales: lists of references in DIMENSION_LIST).
// Throws Error if a scale cannot be read.
std::vector<Hdf5Scale> readScales(hid_t set, std::span<const int64_t> shape);

}  // namespace sluice

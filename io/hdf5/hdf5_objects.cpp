#include "io/hdf5/hdf5_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kMostAttributes = 1000, kMostTextBytes = 1 << 20, kMostNumbers = 1 << 16;
constexpr size_t kMostPositions = 1 << 22;  // along an axis

// Numbers or texts of an attribute; nullopt: another kind.
std::optional<Hdf5Attribute> readAttribute(hid_t object, const char* name) {
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute) return std::nullopt;
  const Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const Handle space(H5Aget_space(attribute.get()), H5Sclose);
  if (!type || !space) return std::nullopt;
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if (count < 1 || count > static_cast<hssize_t>(kMostNumbers)) return std::nullopt;
  Hdf5Attribute found{.name = name, .numbers = {}, .texts = {}};
  const H5T_class_t kind = H5Tget_class(type.get());
  if (kind == H5T_INTEGER || kind == H5T_FLOAT) {
    found.numbers.resize(static_cast<size_t>(count));
    if (H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, found.numbers.data()) < 0) return std::nullopt;
    return found;
  }
  if (kind != H5T_STRING) return std::nullopt;
  const Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_cset(memory.get(), H5Tget_cset(type.get()));
  if (H5Tis_variable_str(type.get()) > 0) {
    H5Tset_size(memory.get(), H5T_VARIABLE);
    std::vector<char*> texts(static_cast<size_t>(count), nullptr);
    if (H5Aread(attribute.get(), memory.get(), texts.data()) < 0) return std::nullopt;
    for (const char* text : texts)
      found.texts.emplace_back(text == nullptr ? std::string() : std::string(text));
    H5Dvlen_reclaim(memory.get(), space.get(), H5P_DEFAULT, texts.data());
    return found;
  }
  const size_t bytes = H5Tget_size(type.get());
  if (bytes == 0 || bytes > kMostTextBytes / static_cast<size_t>(count)) return std::nullopt;
  // A byte more, since texts of a fixed size need not end with a zero.
  H5Tset_size(memory.get(), bytes + 1);
  std::vector<char> all((bytes + 1) * static_cast<size_t>(count), '\0');
  if (H5Aread(attribute.get(), memory.get(), all.data()) < 0) return std::nullopt;
  for (size_t i = 0; i < static_cast<size_t>(count); ++i)
    found.texts.emplace_back(all.data() + i * (bytes + 1));
  return found;
}

// The path of an object; empty: it has none.
std::string pathOf(hid_t object) {
  const ssize_t length = H5Iget_name(object, nullptr, 0);
  if (length <= 0) return "";
  std::string path(static_cast<size_t>(length) + 1, '\0');
  H5Iget_name(object, path.data(), path.size());
  path.pop_back();
  return path;
}

// The scale in a data set of one axis. NetCDF-4 keeps an axis without positions as a set of zeros.
Hdf5Scale readScale(hid_t set, int64_t extent) {
  Hdf5Scale scale{.path = pathOf(set), .values = {}, .attributes = readAttributes(set)};
  for (const Hdf5Attribute& attribute : scale.attributes)
    if (attribute.name == "NAME" && attribute.texts.size() == 1 &&
        attribute.texts[0].starts_with("This is a netCDF dimension but not a netCDF variable"))
      return scale;
  const Handle space(H5Dget_space(set), H5Sclose);
  const Handle type(H5Dget_type(set), H5Tclose);
  if (!space || !type || H5Sget_simple_extent_ndims(space.get()) != 1 ||
      H5Sget_simple_extent_npoints(space.get()) != extent ||
      extent > static_cast<int64_t>(kMostPositions))
    return scale;
  const H5T_class_t kind = H5Tget_class(type.get());
  if (kind != H5T_INTEGER && kind != H5T_FLOAT) return scale;
  scale.values.resize(static_cast<size_t>(extent));
  if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, scale.values.data()) < 0)
    fail("{}: its numbers cannot be read: {}", scale.path, reason());
  return scale;
}

}  // namespace

std::string reason() {
  std::string found;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* error, void* text) -> herr_t {
        if (n == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
        return 0;
      },
      &found);
  for (char& c : found)
    if (c < ' ' || c > '~') c = '?';
  return found.empty() ? "no reason given" : found.substr(0, 200);
}

std::optional<VoxelType> voxelTypeOf(hid_t type) {
  const size_t bytes = H5Tget_size(type);
  switch (H5Tget_class(type)) {
    case H5T_ENUM: {  // h5py's bool
      const Handle base(H5Tget_super(type), H5Tclose);
      return base ? voxelTypeOf(base.get()) : std::nullopt;
    }
    case H5T_INTEGER: {
      if (H5Tget_precision(type) != 8 * bytes) return std::nullopt;
      const bool is_signed = H5Tget_sign(type) == H5T_SGN_2;
      if (bytes == 1) return is_signed ? VoxelType::kI8 : VoxelType::kU8;
      if (bytes == 2) return is_signed ? VoxelType::kI16 : VoxelType::kU16;
      if (bytes == 4) return is_signed ? VoxelType::kI32 : VoxelType::kU32;
      return std::nullopt;
    }
    case H5T_FLOAT:
      if (bytes == 4 && H5Tget_precision(type) == 32) return VoxelType::kF32;
      if (bytes == 8 && H5Tget_precision(type) == 64) return VoxelType::kF64;
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

std::endian orderOf(hid_t type) {
  if (H5Tget_class(type) == H5T_ENUM) {
    const Handle base(H5Tget_super(type), H5Tclose);
    return orderOf(base.get());
  }
  return H5Tget_order(type) == H5T_ORDER_BE ? std::endian::big : std::endian::little;
}

std::vector<int64_t> extentsOf(std::span<const hsize_t> dims) {
  std::vector<int64_t> extents;
  for (const hsize_t dim : dims)
    extents.push_back(static_cast<int64_t>(
        std::min<hsize_t>(dim, static_cast<hsize_t>(std::numeric_limits<int64_t>::max()))));
  return extents;
}

std::vector<Hdf5Attribute> readAttributes(hid_t object) {
  std::vector<std::string> names;
  hsize_t at = 0;
  H5Aiterate2(
      object, H5_INDEX_NAME, H5_ITER_NATIVE, &at,
      [](hid_t, const char* name, const H5A_info_t*, void* list) -> herr_t {
        auto& all = *static_cast<std::vector<std::string>*>(list);
        all.emplace_back(name);
        return all.size() < kMostAttributes ? 0 : 1;
      },
      &names);
  std::vector<Hdf5Attribute> found;
  for (const std::string& name : names)
    if (auto attribute = readAttribute(object, name.c_str()))
      found.push_back(*std::move(attribute));
  return found;
}

std::vector<Hdf5Scale> readScales(hid_t set, std::span<const int64_t> shape) {
  if (H5Aexists(set, "DIMENSION_LIST") <= 0) return {};
  const Handle attribute(H5Aopen(set, "DIMENSION_LIST", H5P_DEFAULT), H5Aclose);
  const Handle space(attribute ? H5Aget_space(attribute.get()) : -1, H5Sclose);
  const Handle type(attribute ? H5Aget_type(attribute.get()) : -1, H5Tclose);
  const Handle memory(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose);
  if (!space || !type || H5Tequal(type.get(), memory.get()) <= 0 ||
      H5Sget_simple_extent_npoints(space.get()) != static_cast<hssize_t>(shape.size()))
    return {};
  std::vector<hvl_t> lists(shape.size(), hvl_t{0, nullptr});
  if (H5Aread(attribute.get(), memory.get(), lists.data()) < 0) return {};
  std::vector<Hdf5Scale> scales(shape.size());
  for (size_t a = 0; a < shape.size(); ++a) {
    if (lists[a].len == 0) continue;
    const Handle scale(H5Rdereference2(set, H5P_DEFAULT, H5R_OBJECT, lists[a].p), H5Oclose);
    if (scale && H5Iget_type(scale.get()) == H5I_DATASET)
      scales[a] = readScale(scale.get(), shape[a]);
  }
  H5Dvlen_reclaim(memory.get(), space.get(), H5P_DEFAULT, lists.data());
  return scales;
}

std::string wordsOf(hid_t type) {
  const size_t bytes = H5Tget_size(type);
  switch (H5Tget_class(type)) {
    case H5T_INTEGER:
      return fmt::format("integers of {} bits", H5Tget_precision(type));
    case H5T_FLOAT:
      return fmt::format("floats of {} bits", H5Tget_precision(type));
    case H5T_STRING:
      return "texts";
    case H5T_COMPOUND:
      return fmt::format("records of {} members ({} bytes)", H5Tget_nmembers(type), bytes);
    case H5T_ENUM:
      return fmt::format("an enumeration of {} bytes", bytes);
    case H5T_ARRAY:
      return fmt::format("arrays of {} bytes", bytes);
    case H5T_REFERENCE:
      return "references";
    case H5T_VLEN:
      return "lists";
    default:
      return fmt::format("values of {} bytes that are no numbers", bytes);
  }
}

}  // namespace sluice

#include "io/hdf5/hdf5_module.h"

#include <hdf5.h>

#include <algorithm>
#include <utility>

#include "io/hdf5/hdf5_objects.h"
#include "src/base/error.h"
#include "src/base/threads/mutex.h"

namespace sluice {
namespace {

constexpr int kMostAxes = 5;

// The library has state of its own and lets in one thread at a time.
Mutex& libraryMutex() {
  static Mutex mutex;
  return mutex;
}

// Every call of the library is made with this lock held. What goes wrong is reported by exceptions:
// without it each thread would print the library's own report once more.
class SLUICE_SCOPED_CAPABILITY LibraryLock {
 public:
  LibraryLock() SLUICE_ACQUIRE(libraryMutex()) : lock_(libraryMutex()) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~LibraryLock() SLUICE_RELEASE() {}
  LibraryLock(const LibraryLock&) = delete;
  LibraryLock& operator=(const LibraryLock&) = delete;

 private:
  MutexLock lock_;
};

class Set final : public Hdf5Set {
 public:
  // Called with the library's mutex held, as all of the private members are.
  Set(std::shared_ptr<Handle> file, const std::string& file_path, const std::string& path)
      : file_(std::move(file)),
        name_(file_path + ":" + path),
        set_(H5Dopen2(file_->get(), path.c_str(), H5P_DEFAULT), H5Dclose) {
    if (!set_) fail("{}: the data set cannot be opened: {}", name_, reason());
    describeVoxels();
    describeStorage();
    description_.attributes = readAttributes(set_.get());
    description_.scales = readScales(set_.get(), description_.shape);
  }
  ~Set() override {
    // Closed with the mutex held.
    const LibraryLock lock;
    { const Handle gone(std::move(set_)); }
    file_.reset();
  }
  Set(const Set&) = delete;
  Set& operator=(const Set&) = delete;

  const Hdf5Description& description() const override { return description_; }

  uint64_t storedBytes(std::span<const int64_t> corner) override {
    const LibraryLock lock;
    hsize_t bytes = 0;
    // A chunk that is missing is a failure to some versions and no bytes to others.
    if (H5Dget_chunk_storage_size(set_.get(), sizes(corner).data(), &bytes) < 0) return 0;
    return bytes;
  }

  uint32_t readStored(std::span<const int64_t> corner, std::span<std::byte> out) override {
    const LibraryLock lock;
    uint32_t mask = 0;
    if (H5Dread_chunk(set_.get(), H5P_DEFAULT, sizes(corner).data(), &mask, out.data()) < 0)
      fail("{}: a chunk cannot be read: {}", name_, reason());
    return mask;
  }

  void readBox(std::span<const int64_t> corner, std::span<const int64_t> extents,
               std::span<std::byte> out) override {
    const LibraryLock lock;
    const Handle space(H5Dget_space(set_.get()), H5Sclose);
    const std::vector<hsize_t> from = sizes(corner), count = sizes(extents);
    const Handle memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                        H5Sclose);
    const Handle type(H5Dget_type(set_.get()), H5Tclose);
    if (H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, from.data(), nullptr, count.data(),
                            nullptr) < 0 ||
        H5Dread(set_.get(), type.get(), memory.get(), space.get(), H5P_DEFAULT, out.data()) < 0)
      fail("{}: voxels cannot be read: {}", name_, reason());
  }

 private:
  static std::vector<hsize_t> sizes(std::span<const int64_t> numbers) {
    return {numbers.begin(), numbers.end()};
  }

  void describeVoxels() {
    const Handle space(H5Dget_space(set_.get()), H5Sclose);
    const int axes = space ? H5Sget_simple_extent_ndims(space.get()) : -1;
    if (axes < 1 || axes > kMostAxes)
      fail("{}: expected an array of 1 to {} axes, found {}", name_, kMostAxes, std::max(axes, 0));
    std::vector<hsize_t> dims(static_cast<size_t>(axes));
    H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr);
    description_.shape = extentsOf(dims);
    const Handle type(H5Dget_type(set_.get()), H5Tclose);
    const auto voxel = type ? voxelTypeOf(type.get()) : std::nullopt;
    if (!voxel)
      fail("{}: expected integers of 8 to 32 bits or floats of 32 or 64, found {}", name_,
           type ? wordsOf(type.get()) : reason());
    description_.type = *voxel;
    description_.byte_order = orderOf(type.get());
  }

  void describeStorage() {
    const Handle list(H5Dget_create_plist(set_.get()), H5Pclose);
    if (!list) fail("{}: the data set cannot be opened: {}", name_, reason());
    if (H5Pget_external_count(list.get()) > 0)
      fail("{}: its voxels lie in other files, which is not read; copy it with h5repack", name_);
    const H5D_layout_t layout = H5Pget_layout(list.get());
    if (layout == H5D_VIRTUAL)
      fail("{}: a virtual data set, which is not read; name one of those that it is made of",
           name_);
    H5D_fill_value_t defined = H5D_FILL_VALUE_UNDEFINED;
    if (H5Pfill_value_defined(list.get(), &defined) >= 0 &&
        defined == H5D_FILL_VALUE_USER_DEFINED &&
        H5Pget_fill_value(list.get(), H5T_NATIVE_DOUBLE, &description_.fill_value) < 0)
      description_.fill_value = 0;
    if (layout == H5D_CONTIGUOUS) {
      const haddr_t at = H5Dget_offset(set_.get());
      if (at != HADDR_UNDEF) description_.in_place_at = at;
    }
    if (layout != H5D_CHUNKED) return;
    std::vector<hsize_t> chunk(description_.shape.size());
    if (H5Pget_chunk(list.get(), static_cast<int>(chunk.size()), chunk.data()) < 0)
      fail("{}: the size of its chunks cannot be read: {}", name_, reason());
    description_.chunks = extentsOf(chunk);
    const int filters = H5Pget_nfilters(list.get());
    for (int i = 0; i < filters; ++i) {
      std::vector<unsigned> values(32);
      std::vector<char> name(64, '\0');
      size_t count = values.size();
      unsigned flags = 0, config = 0;
      const H5Z_filter_t number =
          H5Pget_filter2(list.get(), static_cast<unsigned>(i), &flags, &count, values.data(),
                         name.size() - 1, name.data(), &config);
      if (number < 0) fail("{}: its filters cannot be read: {}", name_, reason());
      values.resize(std::min(count, values.size()));
      Hdf5Filter filter{.number = number, .name = name.data(), .values = std::move(values)};
      for (char& c : filter.name)
        if (c < ' ' || c > '~') c = '?';
      filter.is_in_library = H5Zfilter_avail(number) > 0;
      description_.filters.push_back(std::move(filter));
    }
  }

  std::shared_ptr<Handle> file_;
  const std::string name_;
  Handle set_;
  Hdf5Description description_;
};

class File final : public Hdf5File {
 public:
  explicit File(std::string path) : path_(std::move(path)) {
    const LibraryLock lock;
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_file_locking(access.get(), false, true);  // a file that may only be read is read, too
    file_ =
        std::make_shared<Handle>(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
    if (!*file_)
      fail("{}: expected an HDF5 file, found none that can be opened: {}", path_, reason());
  }
  ~File() override {
    const LibraryLock lock;
    file_.reset();
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  std::vector<Hdf5Entry> sets(size_t most) override {
    const LibraryLock lock;
    struct Visit {
      std::vector<Hdf5Entry> found;
      size_t most;
    } visit{{}, most};
    H5Ovisit2(
        file_->get(), H5_INDEX_NAME, H5_ITER_INC,
        [](hid_t root, const char* name, const H5O_info_t* info, void* user) -> herr_t {
          auto& to = *static_cast<Visit*>(user);
          if (info->type != H5O_TYPE_DATASET) return 0;
          const Handle set(H5Dopen2(root, name, H5P_DEFAULT), H5Dclose);
          const Handle space(set ? H5Dget_space(set.get()) : -1, H5Sclose);
          const int axes = space ? H5Sget_simple_extent_ndims(space.get()) : 0;
          if (axes < 2 || axes > H5S_MAX_RANK) return 0;
          std::vector<hsize_t> dims(static_cast<size_t>(axes));
          H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr);
          to.found.push_back({std::string("/") + name, extentsOf(dims)});
          return to.found.size() < to.most ? 0 : 1;
        },
        &visit, H5O_INFO_BASIC);
    return visit.found;
  }

  bool has(const std::string& path) override {
    const LibraryLock lock;
    return exists(path);
  }

  std::unique_ptr<Hdf5Set> open(const std::string& path) override {
    const LibraryLock lock;
    if (!exists(path)) fail("{}: expected a data set {}, found none", path_, path);
    return std::make_unique<Set>(file_, path_, path);
  }

  std::vector<Hdf5Attribute> attributes(const std::string& path) override {
    const LibraryLock lock;
    if (!exists(path)) return {};
    const Handle object(H5Oopen(file_->get(), path.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object) return {};
    return readAttributes(object.get());
  }

 private:
  // Along the way no link leads out of the file.
  bool exists(const std::string& path) const {
    for (size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
      const std::string part = path.substr(0, end);
      if (part.empty() || part == "/") return part == "/" && end == std::string::npos;
      H5L_info_t info;
      if (H5Lget_info(file_->get(), part.c_str(), &info, H5P_DEFAULT) < 0) return false;
      if (info.type != H5L_TYPE_HARD && info.type != H5L_TYPE_SOFT)
        fail("{}: {} leads to another file, which is not followed; name that file", path_, part);
      if (end == std::string::npos)
        return H5Oexists_by_name(file_->get(), part.c_str(), H5P_DEFAULT) > 0;
    }
  }

  const std::string path_;
  std::shared_ptr<Handle> file_;
};

}  // namespace
}  // namespace sluice

extern "C" const char* sluiceOpenHdf5Version() {
  return sluice::kHdf5ModuleVersion;
}

extern "C" void sluiceOpenHdf5(const std::string& path, std::shared_ptr<sluice::Hdf5File>& file) {
  file = std::make_shared<sluice::File>(path);
}

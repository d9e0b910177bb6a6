#include "io/fetch_volume.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <set>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "io/formats.h"
#include "io/stores/sha256.h"
#include "io/web/web_place.h"
#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/n5/n5_attributes.h"
#include "io/zarr/reading/zarr_checksums.h"
#include "src/base/error.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/suffixed_name.h"
#include "src/base/threads/mutex.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// Objects of a store that are read at once.
constexpr int kObjectsAtOnce = 8;

std::string lastPart(const std::string& key) {
  return key.substr(key.rfind('/') + 1);
}

// The metadata that a reader of a store asks for, so that they need not be looked for.
class RecordingStore final : public ChunkStore {
 public:
  explicit RecordingStore(std::shared_ptr<ChunkStore> store) : store_(std::move(store)) {}

  std::set<std::string> metadata() const {
    const MutexLock lock(mutex_);
    return metadata_;
  }

  std::string wholeKey(const std::string& key) const override { return store_->wholeKey(key); }
  std::string nameOf(const std::string& key) const override { return store_->nameOf(key); }
  void expect(const std::vector<std::string>& keys) override { store_->expect(keys); }
  bool has(const std::string& key) override { return noted(key, store_->has(key)); }
  bool read(const std::string& key, const PieceBytes& wanted, const Room& room) override {
    return noted(key, store_->read(key, wanted, room));
  }
  std::string stampOf(const std::string& key) override { return store_->stampOf(key); }
  int distantReads() const override { return store_->distantReads(); }
  bool canList() const override { return store_->canList(); }
  void list(const std::string& folder,
            const std::function<void(const Entry& entry)>& take) override {
    store_->list(folder, take);
  }

 private:
  bool noted(const std::string& key, bool is_there) {
    const std::string name = lastPart(key);
    if (is_there && std::ranges::find(kStoreMetadata, name) != kStoreMetadata.end()) {
      const MutexLock lock(mutex_);
      metadata_.insert(key);
    }
    return is_there;
  }

  const std::shared_ptr<ChunkStore> store_;
  mutable Mutex mutex_;
  std::set<std::string> metadata_ SLUICE_GUARDED_BY(mutex_);
};

std::string textOf(ChunkStore& store, const std::string& key) {
  std::string text;
  store.read(key, {}, [&](const PieceInfo& piece) {
    text.resize(piece.bytes);
    return std::as_writable_bytes(std::span(text));
  });
  return text;
}

// All of a short file; empty: it cannot be read, or is longer than any that is written.
std::string textIn(const Descriptor& file) {
  constexpr size_t kMostBytes = 1 << 16;
  std::string text(kMostBytes, '\0');
  const ssize_t got = pread(file.get(), text.data(), text.size(), 0);
  text.resize(got > 0 && static_cast<size_t>(got) < kMostBytes ? static_cast<size_t>(got) : 0);
  return text;
}

// Whether it is what StoreFetch writes: a name and 64 digits, a line each.
bool isOrigin(const std::string& text) {
  constexpr size_t kDigits = 64;
  const size_t end = text.find('\n');
  return end != std::string::npos && text.size() == end + 1 + kDigits + 1 &&
         text.find_first_not_of("0123456789abcdef", end + 1) == text.size() - 1;
}

// Makes a folder with those above it. At the end, the ones that it made and that hold nothing go.
class MadeFolders {
 public:
  explicit MadeFolders(fs::path folder) {
    std::error_code ignored;  // opening a file in the folder tells why there is none
    for (fs::path at = std::move(folder); !at.empty() && !fs::exists(at, ignored);
         at = at.parent_path())
      made_.push_back(at);
    if (!made_.empty()) fs::create_directories(made_.front(), ignored);
  }
  ~MadeFolders() {
    std::error_code holds_something;
    for (const fs::path& folder : made_) fs::remove(folder, holds_something);
  }
  MadeFolders(const MadeFolders&) = delete;
  MadeFolders& operator=(const MadeFolders&) = delete;

 private:
  std::vector<fs::path> made_;  // the deepest first
};

// Removes the folders below and including `root` that hold no file.
void removeEmptyFolders(const fs::path& root) {
  std::error_code ignored;
  std::vector<fs::path> folders{root};
  for (fs::recursive_directory_iterator it(root, ignored), end; !ignored && it != end;
       it.increment(ignored))
    if (it->is_directory(ignored) && !it->is_symlink(ignored)) folders.push_back(it->path());
  // A folder comes after the one that it lies in, so that the deepest are tried first.
  for (size_t i = folders.size(); i-- > 0;) fs::remove(folders[i], ignored);
}

// The array that a metadata file describes; nullopt: it is a group's.
std::optional<ZarrArray> arrayIn(const std::string& name, const std::string& text,
                                 const std::string& path) {
  if (name == ".zarray" || (name == "zarr.json" && isZarrArray(text, path)))
    return parseZarrArray(text, path);
  if (name == "attributes.json" && isN5Array(text, path)) return parseN5Array(text, path);
  return std::nullopt;
}

class StoreFetch {
 public:
  StoreFetch(StorePlace root, const fs::path& target, const FetchOptions& options,
             ProgressMeter& progress)
      : root_(std::move(root)),
        target_(target),
        part_(suffixedName(target, ".part")),
        origin_path_(suffixedName(target, ".part-of")),
        options_(options),
        progress_(progress) {
    one_.reads = 1;
    one_.has_checksum = false;
    one_.stop = options.download.stop;
  }

  FetchedVolume run(const std::string& address) {
    const std::set<std::string> metadata = findMetadata(address);
    const MadeFolders above(origin_path_.parent_path());
    const Descriptor origin = takeOrigin(metadata);
    const Leftovers leftovers{part_, origin_path_};
    // The metadata first: they are small, and say which chunks there are.
    for (const std::string& key : metadata) fetchOne(key);
    for (const std::string& key : metadata) fetchArray(key);
    std::error_code error;
    // The store has its name only once all of it is there.
    fs::rename(part_, target_, error);
    if (error) fail("{}: cannot be written: {}", target_.string(), error.message());
    fs::remove(origin_path_, error);
    FetchedVolume fetched{.is_store = true, .files = files_, .missing_files = missing_};
    fetched.object.bytes = bytes_;
    fetched.object.resumed_bytes = resumed_bytes_;
    return fetched;
  }

 private:
  // Whatever ends a fetch, no folder without a file stays; nor does the origin of no file at all.
  struct Leftovers {
    const fs::path &part, &origin;
    ~Leftovers() {
      removeEmptyFolders(part);
      std::error_code ignored;
      if (!fs::exists(part, ignored)) fs::remove(origin, ignored);
    }
  };

  // The keys of all metadata below the root, of the volume and of its levels.
  std::set<std::string> findMetadata(const std::string& address) const {
    const auto recording = std::make_shared<RecordingStore>(root_.store);
    NamedInput input;
    input.name = address;
    input.store = StorePlace{recording, root_.key};
    const Format& format = formatOf(input, options_.open);
    format.open(input, options_.open);
    std::set<std::string> keys;
    for (const std::string& key : recording->metadata()) {
      if (!key.starts_with(root_.key + "/")) continue;  // an image around it
      keys.insert(key);
      addAround(key, keys);
    }
    return keys;
  }

  // The file that says where the files of the store come from, for this process alone. Files that
  // are there go if they come from another store, or if its metadata have changed since: chunks of
  // two stores would be one volume.
  Descriptor takeOrigin(const std::set<std::string>& metadata) const {
    Sha256 sha;
    for (const std::string& key : metadata)
      for (const std::string& text : {key, root_.store->stampOf(key), textOf(*root_.store, key)}) {
        // The length is added, too, so that two texts cannot be taken for others of the same
        // letters.
        const uint64_t bytes = text.size();
        sha.add(std::as_bytes(std::span(&bytes, 1)));
        sha.add(std::as_bytes(std::span(text)));
      }
    const std::string origin = fmt::format("{}\n{}\n", root_.name(), sha.finish());
    const std::string path = origin_path_.string();
    std::error_code error;
    Descriptor file = openAlone(path);
    if (!file) fail("{}: another process is fetching it", target_.string());
    const std::string known = textIn(file);
    if (known == origin) return file;
    if (!isOrigin(known) && (!known.empty() || fs::exists(part_, error))) {
      if (known.empty()) fs::remove(origin_path_, error);
      fail("{}: expected nothing of this name, or what a fetch began; move or remove it",
           known.empty() ? part_.string() : path);
    }
    fs::remove_all(part_, error);
    if (error) fail("{}: cannot be removed: {}", part_.string(), error.message());
    const std::string what = fmt::format("{}: cannot be written", path);
    if (ftruncate(file.get(), 0) != 0) failErrno(what, errno);
    writeAllAt(file.get(), std::as_bytes(std::span(origin)), 0, what);
    return file;
  }

  // Metadata that other programs expect beside a key and in the folders that it lies in: a group's,
  // attributes of its own.
  void addAround(const std::string& key, std::set<std::string>& keys) const {
    const std::string kind = lastPart(key);
    const std::vector<std::string> names =
        kind.starts_with(".z") ? std::vector<std::string>{".zarray", ".zattrs", ".zgroup"}
                               : std::vector<std::string>{kind};
    for (std::string folder = key; folder.size() > root_.key.size();) {
      folder.resize(folder.rfind('/'));
      for (const std::string& name : names) {
        const std::string beside = fmt::format("{}/{}", folder, name);
        if (!keys.contains(beside) && root_.store->has(beside)) keys.insert(beside);
      }
    }
  }

  fs::path fileOf(const std::string& key) const {
    const fs::path below = key.substr(root_.key.size() + 1);
    // A name from a server must not lead out of the folder.
    for (const fs::path& part : below)
      if (part == ".." || part.is_absolute())
        fail("{}: expected names of files below the store's", root_.store->nameOf(key));
    return part_ / below;
  }

  void fetchOne(const std::string& key) {
    const fs::path file = fileOf(key);
    std::error_code error;
    // A file under its own name is whole, since download() renames it at the end.
    if (const uintmax_t bytes = fs::file_size(file, error); !error) {
      ++files_;
      bytes_ += bytes;
      resumed_bytes_ += bytes;
      return;
    }
    fs::create_directories(file.parent_path(), error);
    if (error) fail("{}: cannot be written: {}", file.parent_path().string(), error.message());
    ProgressMeter nobody;
    const auto done = download({root_.store, key}, file, {}, one_, nobody);
    // A chunk of nothing but the fill value need not be there.
    if (!done) {
      ++missing_;
      return;
    }
    ++files_;
    bytes_ += done->bytes;
    resumed_bytes_ += done->resumed_bytes;
  }

  // All chunks or shards of the array that a metadata file describes.
  void fetchArray(const std::string& key) {
    const auto array = arrayIn(lastPart(key), textOf(*root_.store, key), root_.store->nameOf(key));
    if (!array) return;
    const StorePlace folder{root_.store, key.substr(0, key.rfind('/'))};
    // The checksums are part of a store of `sluice pack`; other stores have none.
    const std::string checksums(kZarrChecksumsName);
    if (folder.has(checksums)) fetchOne(folder.at(checksums).key);
    const int64_t count = array->fileCount();
    progress_.expect(static_cast<uint64_t>(count));
    WorkerPool pool(kObjectsAtOnce);
    pool.parallelFor(count, [&](int64_t file) {
      options_.download.stop.throwIfStopped();
      fetchOne(folder.at(array->fileName(file)).key);
      progress_.add(1);
    });
  }

  const StorePlace root_;
  const fs::path& target_;
  const fs::path part_, origin_path_;
  const FetchOptions& options_;
  ProgressMeter& progress_;
  DownloadOptions one_;
  std::atomic<int64_t> files_{0}, missing_{0};
  std::atomic<uint64_t> bytes_{0}, resumed_bytes_{0};
};

}  // namespace

FetchedVolume fetchVolume(const std::string& address, const fs::path& target,
                          const FetchOptions& options, ProgressMeter& progress) {
  const StorePlace place = webPlace(address, options.open.web, options.open.stop);
  if (isStore(place)) {
    if (options.expected.bytes || !options.expected.sha256.empty())
      fail("{}: a store of many files, which has no size and checksum of its own", place.name());
    return StoreFetch(place, target, options, progress).run(address);
  }
  const auto done = download(place, target, options.expected, options.download, progress);
  if (!done) fail("{}: the server has no such file; check the address", place.name());
  FetchedVolume fetched;
  fetched.object = *done;
  return fetched;
}

}  // namespace sluice

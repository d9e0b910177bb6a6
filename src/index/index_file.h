// The store of data that is computed once from a volume and wanted at every opening: the min-max
// index.
//
// An index is a blob under a key. It lies in the user's cache folder, so that neither a scan nor a
// Zarr group gets files that are none of its own, or where the user wants it. A blob is given back
// only if the whole of its file is intact and its key is the one asked for; a stale or torn one
// counts as missing and is written anew. Nothing here throws for a folder that cannot be read or
// written: an index is a convenience. All functions may be called from any thread and by several
// processes at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

struct IndexKey {
  std::string identity;  // VolumeSource::identity(): changes whenever the voxels may have
  std::string what;      // tells blobs of one volume apart and names the file: "minmax-32"
  uint32_t version = 0;  // version of the blob's format
};

// The part of IndexKey::what that tells apart the blobs which one volume name has at the same time:
// voxel type, dimensions given by the user, grids of an OpenVDB file, channels, time steps.
std::string selectionOf(const VolumeLayout& volume, int64_t time);

struct IndexPlaces {
  std::filesystem::path written;               // empty: nowhere
  std::vector<std::filesystem::path> folders;  // read, in the order they are tried
  bool disabled = false;                       // by the user; nothing is read or written then
};

// The user's choice where indices are kept, for all volumes.
struct IndexWish {
  std::filesystem::path folder = {};  // empty: none
  bool beside = false;  // next to each volume, read first and written; the folder is read after it
  bool disabled = false;  // no index is read or written
};

// For a volume as the user names it: NAME-HASH in the folder, and, read after it,
// VOLUME.sluice-index next to the volume, which others may have put there. A synthetic volume has
// no place next to it.
IndexPlaces indexPlaces(const std::string& volume, const IndexWish& wish);

enum class IndexState {
  kFound,
  kMissing,  // no file of that name anywhere
  kStale,    // an intact file for another identity or version
  kTorn,     // cut short, overwritten in part, or something else altogether
  kDisabled,
};
std::string_view name(IndexState state);  // "found", "missing", ...

struct IndexRead {
  IndexState state = IndexState::kMissing;
  std::optional<std::vector<std::byte>> blob;  // when kFound
  std::filesystem::path path;  // the file that was found, or the first that was rejected
  std::string note;            // why it was rejected; empty otherwise
};
// The first intact blob of this key.
IndexRead readIndex(const IndexPlaces& places, const IndexKey& key);

struct IndexWritten {
  std::filesystem::path path;  // empty when it could be written nowhere
  std::string note;            // why it could not, in one short line; empty otherwise
};
// How a caller came by the content of an index.
enum class IndexOrigin { kRead, kBuilt, kBuiltNotKept, kNotMade };
// "read", "built", "built, not kept", "not made".
std::string_view name(IndexOrigin origin);
// The origin of a content that was built and written to `path`, which is empty if it is not kept.
inline IndexOrigin builtOrigin(const std::filesystem::path& path) {
  return path.empty() ? IndexOrigin::kBuiltNotKept : IndexOrigin::kBuilt;
}

// Writes to the one place, whole or not at all.
IndexWritten writeIndex(const IndexPlaces& places, const IndexKey& key,
                        std::span<const std::byte> blob);

// Removes all indices in `folder`, which belongs to one volume. False when one of them cannot be
// removed.
bool removeIndices(const std::filesystem::path& folder);

}  // namespace sluice

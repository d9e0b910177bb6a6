// Volume: a volume on disk or in memory, open for drawing. It holds everything known about the
// volume without its voxels; these are read when pictures need them, so that the volume may be
// larger than memory.
#pragma once

#include <sluice/array.h>
#include <sluice/error.h>
#include <sluice/progress.h>
#include <sluice/report.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace sluice {

// How to read a volume if its file does not tell, and the resources for opening it.
struct VolumeOptions {
  // Raw files only; other files contain these. A raw file's name may contain them too:
  // head_256x256x225_uint8.raw.
  std::optional<std::array<int64_t, 3>> dims = {};  // voxels along x, y, z; x fastest
  std::string type = {};  // "u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"; empty: by name
  bool big_endian = false;
  int64_t skip_bytes = 0;                  // in front of the first voxel
  std::optional<int64_t> time_steps = {};  // stored one after the other; unset: 1, or by name
  // Any file: world units between neighbouring voxels, instead of the file's.
  std::optional<std::array<double, 3>> spacing = {};
  std::string grid = {};                // grid of OpenVDB, series of DICOM; empty: first, largest
  std::optional<int64_t> channel = {};  // channel by its number; unset: the first
  // The same by its name, if `channel` is unset. Several that pictures show together, at most 8,
  // have commas between: "0,2" or "DAPI,GFP". With neither, pictures of a file that says how its
  // channels look (OME) show its active channels, and those of other files the first channel.
  std::string channel_name = {};
  // The file or address of a further volume, which pictures show together with this one at its own
  // place in the world: labels over a scan, for example. Of several channels, its first one.
  std::string over = {};

  // Volumes at addresses (https://..., s3://...).
  struct Web {
    std::string cache_folder = {};  // keeps what was read; empty: nothing is kept
    uint64_t cache_bytes = 0;       // the limit of that folder
    // The key of requests to s3://; empty: they are not signed.
    std::string access_key = {}, secret_key = {}, session_token = {};
    std::string region = {};    // empty: us-east-1
    std::string endpoint = {};  // "http://127.0.0.1:9000"; empty: Amazon's
    // The authorities that https:// trusts: a file of certificates (PEM), or a folder of them as
    // `openssl rehash` arranges it. Both empty: the system's.
    std::string certificate_file = {}, certificate_folder = {};
  };

  // For a series: whether the value range, looks chosen by it, and fits cover all steps, whose
  // indices are then made when the volume is opened. Otherwise range and look follow from the step
  // `time`, and fits from the step that is drawn.
  bool whole_series = true;
  int64_t time = 0;  // from 0; the step whose index is made first

  // A large or distant volume whose file has coarser levels of resolution is opened without passing
  // over its finest level: the value range and looks chosen by it come from a coarse level, and may
  // differ a little. VolumeInfo::warnings says so. Pictures are drawn from its levels, which shows
  // thin structures fainter if they hold means without spreads. Other volumes open as usual.
  bool opens_soon = false;

  // The folder that keeps the least and greatest values of blocks for the next opening, an index of
  // a few thousandths of the volume's size. Empty: none, and each opening passes over the voxels,
  // unless an index lies next to the volume.
  std::string index_folder = {};
  // Whether coarser levels are made, once and beside the index, for a volume whose file has none:
  // never, but those that were made before are used; if it is large; always; or never, and those
  // that were made are not used either.
  enum class Levels { kKept, kAuto, kAlways, kNone };
  Levels levels = Levels::kKept;
  Web web = {};
  std::string temporary_folder = {};  // for decoding; empty: /var/tmp, or /tmp
  // Voxels along the sides of a block, the unit of reading: a power of two from 4 to 1024; and of a
  // page of the texture cache, powers of two. Unset: the longest side of the page; what the 64 KiB
  // page of graphics hardware holds of the voxel type.
  std::optional<int64_t> block = {};
  std::optional<std::array<int64_t, 3>> page = {};
  uint64_t memory_bytes = 0;  // limit for the pass; 0: half of the machine's
  int threads = 0;            // for the pass; 0: one a core
};

// Properties of a volume. Plain data.
struct VolumeInfo {
  std::string name;               // for people: the file's or the grid's
  std::array<int64_t, 3> dims;    // voxels along x, y, z
  std::string type;               // a name of VolumeOptions::type
  std::array<double, 3> spacing;  // world units between neighbouring voxels
  std::array<double, 3> origin;   // world position of the first voxel
  std::string unit;               // unit of spacing and origin; empty if the file does not tell
  // Unit directions of the world along which x, y and z run.
  std::array<std::array<double, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  // The meaning of the world's axes: "RAS" and "LPS" (of a patient: x to the right or left, y to
  // the front or back, z up), "rows" (y down the rows of pictures), "y-up", or empty: not known.
  std::string frame;
  int64_t time_steps = 1;
  std::vector<std::string> channels;  // that pictures show together, for people; empty: only one
  int levels = 1;                     // levels of resolution that pictures may be drawn from
  bool was_opened_soon = false;       // VolumeOptions::opens_soon made a difference
  std::array<double, 2> value_range;  // least and greatest
  // For people, one line each: choices among several, possible faults of the file, and an index or
  // a cache that could not be written while the volume was opened.
  std::vector<std::string> warnings;
  // The files that it is read from, as far as is known; do not write over them.
  std::vector<std::string> files;
};

class Ranks;
struct LentBox;

// A handle: copies are the same open volume, which closes with the last of them and the last
// Renderer of it. Any thread may call, several at once.
class Volume {
 public:
  // `path`: a file (NRRD, MetaImage, NIfTI, VTK, OpenVDB, DICOM, raw, PNG or TIFF slices), a
  // folder of slices, an OME-Zarr image or Zarr array, a pattern ("step_%03d.nrrd"), or
  // "synth:KIND,..."; of several paths each is a slice or a time step.
  //
  // Reads the volume's index, or passes over its voxels once, telling `progress`. Throws Error,
  // which names the file: it is missing, damaged, of another size than its header or of no known
  // kind; or the options do not suit it, there is no such time step, or the memory is too small.
  // Throws Cancelled when `stop` asks for it.
  explicit Volume(const std::string& path, const VolumeOptions& options = {},
                  const ProgressFunction& progress = {}, const std::stop_token& stop = {});
  explicit Volume(const std::vector<std::string>& paths, const VolumeOptions& options = {},
                  const ProgressFunction& progress = {}, const std::stop_token& stop = {});

  // An array that is in memory already, the voxel (0, 0, 0) of step 0 at `first`. It is not copied
  // as a whole: pictures copy the blocks that they show, within their budget. It must stay as it is
  // as long as the volume is open. `strides` unset: packed, x fastest. Of `options` those of a file
  // and of folders are ignored. Throws Error, which names `layout.name`: dims, type, place or steps
  // that none can be, no array; Cancelled.
  static Volume borrow(const void* first, const ArrayLayout& layout,
                       const std::optional<ArrayStrides>& strides = {},
                       const VolumeOptions& options = {}, const ProgressFunction& progress = {},
                       const std::stop_token& stop = {});
  // The part of a volume that this process has, of which the other ranks have the rest; see
  // in_situ.h, which has LentBox and Ranks. `first` is the array's first voxel, the lowest of the
  // ghosts, and `layout` that of the whole volume, of one time step. `strides` unset: the array
  // with its ghosts is packed, x fastest. All ranks call. The voxels must stay as they are until
  // the volume is closed: borrow them again after each step of a simulation. info() is of the whole
  // volume. Throws Error at every rank: as above, or the boxes do not tile the volume or cannot be
  // put in order, ghosts are missing.
  static Volume borrow(const void* first, const ArrayLayout& layout, const LentBox& box,
                       const Ranks& ranks, const std::optional<ArrayStrides>& strides = {},
                       const VolumeOptions& options = {}, const ProgressFunction& progress = {},
                       const std::stop_token& stop = {});
  // Voxels that `fill` gives whenever they are needed, perhaps several times. Otherwise as
  // borrow().
  static Volume fromFunction(FillBox fill, const ArrayLayout& layout,
                             const VolumeOptions& options = {},
                             const ProgressFunction& progress = {},
                             const std::stop_token& stop = {});

  // The key for s3:// addresses, their region and server, from where Amazon's own tools look for
  // them: `variable` gives a variable of the environment, or nothing if it is not set. The cache is
  // none. Throws Error if AWS_PROFILE names a profile that no file has.
  static VolumeOptions::Web bucketAccess(
      const std::function<std::string(const std::string& name)>& variable);

  const VolumeInfo& info() const;
  // The values of all voxels; for a series that was opened whole, of all its steps. They are known
  // in up to 4096 intervals. Where a volume has more values, those of an interval count as spread
  // evenly over it. Requires: bins > 0.
  ValueHistogram histogram(int bins = 256) const;

 private:
  friend class Renderer;
  struct Impl;
  explicit Volume(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

}  // namespace sluice

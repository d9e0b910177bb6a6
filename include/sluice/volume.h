// Volume: a volume on disk, open for drawing. It holds what is known of the volume without its
// voxels; these are read when pictures need them, so that it may be larger than memory.
#pragma once

#include <sluice/error.h>
#include <sluice/progress.h>
#include <sluice/report.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace sluice {

// How to read a volume where its file does not say, and what opening it may take.
struct VolumeOptions {
  // Raw files only; others say it themselves. Their names may say it too:
  // head_256x256x225_uint8.raw.
  std::optional<std::array<int64_t, 3>> dims = {};  // voxels along x, y, z; x fastest
  std::string type = {};  // "u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"; empty: by name
  bool big_endian = false;
  int64_t skip_bytes = 0;                  // in front of the first voxel
  std::optional<int64_t> time_steps = {};  // one after the other; unset: 1, or by name
  // Any file: world units between neighbouring voxels, in place of what the file says.
  std::optional<std::array<double, 3>> spacing = {};
  std::string grid = {};                // of an OpenVDB file; empty: the first that can be drawn
  std::optional<int64_t> channel = {};  // of a Zarr store or TIFF pages; unset: the first
  std::string channel_name = {};        // the same by its name, where `channel` is unset

  // Of a series: value range, looks that are chosen by it and fits are those of all steps, whose
  // indices are made at the opening. Otherwise range and look are those of the step `time`, and
  // fits are those of the step that is drawn.
  bool whole_series = true;
  int64_t time = 0;  // from 0; the step whose index is made first

  // Where the least and greatest values of blocks are kept for the next opening, an index of a few
  // thousandths of the volume's size; empty: nowhere, and each opening passes over the voxels,
  // unless an index lies beside the volume.
  std::string index_folder = {};
  std::string temporary_folder = {};  // for decoding; empty: /var/tmp, or /tmp
  uint64_t memory_bytes = 0;          // that the pass may take; 0: half of the machine's
  int threads = 0;                    // of the pass; 0: one a core
};

// What is known of a volume. Plain data.
struct VolumeInfo {
  std::string name;               // for people: the file's or the grid's
  std::array<int64_t, 3> dims;    // voxels along x, y, z
  std::string type;               // as in VolumeOptions
  std::array<double, 3> spacing;  // world units between neighbouring voxels
  std::array<double, 3> origin;   // world position of the first voxel
  std::string unit;               // of these; empty where the file does not say
  // Unit directions of the world along which x, y and z run.
  std::array<std::array<double, 3>, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  // What the world's axes mean: "RAS" and "LPS" (of a patient: x to the right or left, y to the
  // front or back, z up), "rows" (y down the rows of pictures), "y-up", or empty: not known.
  std::string frame;
  int64_t time_steps = 1;
  std::array<double, 2> value_range;  // least and greatest
  // For people, one line each: what was chosen among several and what looks wrong.
  std::vector<std::string> warnings;
  // That it is read from, as far as is known: nothing should be written over them.
  std::vector<std::string> files;
};

// A handle: copies are the same open volume, which closes with the last of them and the last
// Renderer of it. Any thread, several at once.
class Volume {
 public:
  // `path`: a file (NRRD, MetaImage, NIfTI, OpenVDB, raw, PNG or TIFF slices), a folder of slices,
  // an OME-Zarr image or Zarr array, a pattern ("step_%03d.nrrd"), or "synth:KIND,..."; of several
  // paths each is a slice or a time step.
  //
  // Reads the volume's index, or passes over its voxels once, telling `progress`. Throws Error,
  // which names the file: it is missing, damaged, of another size than it says or of no known
  // kind, options that it does not take, no such time step, too little memory. Throws Cancelled
  // when `stop` asks for it.
  explicit Volume(const std::string& path, const VolumeOptions& options = {},
                  const ProgressFunction& progress = {}, const std::stop_token& stop = {});
  explicit Volume(const std::vector<std::string>& paths, const VolumeOptions& options = {},
                  const ProgressFunction& progress = {}, const std::stop_token& stop = {});

  const VolumeInfo& info() const;
  // Of all voxels; of a series, of all its steps where it was opened whole. Requires: bins > 0.
  ValueHistogram histogram(int bins = 256) const;

 private:
  friend class Renderer;
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace sluice

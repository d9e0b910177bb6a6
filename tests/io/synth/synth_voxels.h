// The voxels of small synthetic volumes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "io/synth/synth_source.h"

namespace sluice {

template <class T>
std::vector<T> readBox(VolumeSource& source, const Box3& box, int64_t time = 0) {
  std::vector<T> voxels(static_cast<size_t>(box.count()));
  source.readRegion(time, box, std::as_writable_bytes(std::span(voxels)));
  return voxels;
}

template <class T>
std::vector<T> readAll(const SynthOptions& options, int64_t time = 0) {
  return readBox<T>(*openSynth(options), boxOf(options.dims), time);
}

inline double shareOf(const std::vector<uint8_t>& voxels) {
  const auto zeros = std::count(voxels.begin(), voxels.end(), 0);
  return 1 - static_cast<double>(zeros) / static_cast<double>(voxels.size());
}

inline SynthOptions small(SynthKind kind) {
  SynthOptions options;
  options.kind = kind;
  options.dims = {70, 50, 66};
  options.object_share = 0.2;
  if (kind == SynthKind::kFlow || kind == SynthKind::kMixing) options.time_steps = 3;
  return options;
}

}  // namespace sluice

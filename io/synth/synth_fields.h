// The formulas behind synth_source.h, a row of voxels at a time.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "io/synth/synth_source.h"

namespace sluice {

// A scalar field on the voxels of a volume. Constant after construction; any thread may call.
class SynthField {
 public:
  virtual ~SynthField() = default;

  // Writes voxels x0, x0 + 1, ... of row (y, z) at step `time` to `row`, 0..1; false when all of
  // them are 0, leaving `row` as it is.
  virtual bool fillRow(int64_t time, int64_t y, int64_t z, int64_t x0,
                       std::span<float> row) const = 0;

  // Voxels outside are 0 at every step.
  virtual Box3 objectBox() const { return box_; }

 protected:
  explicit SynthField(Vec3i dims) : box_(boxOf(dims)) {}

 private:
  const Box3 box_;
};

// A field for each kind, see synth_source.h. Requires: options that openSynth() has checked.
std::unique_ptr<SynthField> makePhantomField(const SynthOptions& options);
std::unique_ptr<SynthField> makeShellsField(const SynthOptions& options);
std::unique_ptr<SynthField> makeMarschnerLobbField(const SynthOptions& options);
std::unique_ptr<SynthField> makeNoiseField(const SynthOptions& options);
std::unique_ptr<SynthField> makeSparseField(const SynthOptions& options);
std::unique_ptr<SynthField> makeSlabField(const SynthOptions& options);
std::unique_ptr<SynthField> makeFlowField(const SynthOptions& options);
std::unique_ptr<SynthField> makeMixingField(const SynthOptions& options);
std::unique_ptr<SynthField> makeCubeField(const SynthOptions& options);
std::unique_ptr<SynthField> makePartsField(const SynthOptions& options);

// The most time steps of a kind that varies: `flow` keeps the particles of each.
inline constexpr int64_t kMaxSynthSteps = 10000;

// A tile of smoothed noise that repeats every 64 voxels: fine texture for a table look-up a voxel.
class TextureTile {
 public:
  explicit TextureTile(uint64_t seed);
  // row[i] += amplitude * texture at (x0 + i, y, z); the texture is within -1..1.
  void add(std::span<float> row, int64_t x0, int64_t y, int64_t z, float amplitude) const;

 private:
  std::vector<float> values_;  // 64^3, x fastest
};

}  // namespace sluice

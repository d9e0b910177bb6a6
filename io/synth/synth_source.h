// Synthetic volumes: procedural volumes of any size behind VolumeSource, computed region by region.
//
// Deterministic: a voxel depends on the options and its position alone, not on the machine, the
// thread, or the box that it is read with. Nothing is held but a few tables (about 1 MB; `flow`
// 8 KB a time step). Any thread may read.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "src/base/sources/synth_name.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

enum class SynthKind {
  kPhantom,        // the 3D Shepp-Logan head (Kak & Slaney's ellipsoids) with fine texture
  kShells,         // nested spherical shells with soft walls and air between them
  kMarschnerLobb,  // the test signal of Marschner & Lobb 1994, near the Nyquist rate at 40 voxels
  kNoise,          // clouds: value noise of several octaves above a threshold
  kSparse,         // balls of 32 voxels, scattered
  kSlab,           // a textured slab across the middle of z
  kFlow,           // vortex rings carried by an ABC flow, varying with time
  kMixing,         // two gases that mix across a layer, varying with time
  kCube,           // the same value everywhere
  kParts,          // the ellipsoids of kPhantom as labels, 1 to 10, without levels
};

// The kinds in the order of the enum, and their names in specs and `sluice synth`.
std::span<const SynthKind> synthKinds();
std::string_view name(SynthKind kind);           // "phantom", "marschner-lobb", ...
std::string_view descriptionOf(SynthKind kind);  // a few words for a help page
std::optional<SynthKind> parseSynthKind(std::string_view text);

struct SynthOptions {
  SynthKind kind = SynthKind::kPhantom;
  Vec3i dims{256, 256, 256};
  VoxelType type =
      VoxelType::kU8;      // u8, u16 or f32; values fill 0..255, 0..65535, 0..1, but for labels
  int64_t time_steps = 1;  // more than one: flow and mixing only
  uint64_t seed = 1;
  // Share of the voxels that are not zero: slab (rounded to planes), sparse (expected, at most
  // 0.4), noise (estimated within about 0.01). The other kinds' share follows from their shape.
  double object_share = 0.05;
  Vec3d spacing{1, 1, 1};
  int64_t levels = 1;  // levels of resolution, see mean_levels.h
};

// "synth:KIND[,dims=XxYxZ][,type=T][,steps=N][,seed=N][,share=S][,spacing=XxYxZ][,levels=N]"; the
// leading
// "synth:" may be missing. Throws Error that names the part at fault.
SynthOptions parseSynthSpec(std::string_view spec);
// The spec, every field named; parseSynthSpec takes it back.
std::string specOf(const SynthOptions& options);

// Throws Error when an option is out of range.
std::unique_ptr<VolumeSource> openSynth(const SynthOptions& options);

}  // namespace sluice

#include "src/cpu/kernels/kernel_frame.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "src/base/error.h"
#include "src/cpu/kernels/floats.h"
#include "src/device/pictures/blue_noise.h"
#include "src/device/shading/rough_light.h"

namespace sluice {
namespace {

// From here on nothing behind a pixel can be seen: a tenth of 1/255.
constexpr float kNothingMore = 1 - 4e-4F;

// Perspective views look up a logarithm: from here on opaque.
constexpr double kMostExponent = 32;

}  // namespace

LookUpTables::LookUpTables(LookUpKey of, Channels of_channels)
    : key(std::move(of)),
      channels(of_channels),
      entries(lookUpTexels(key)),
      visible(visibleValues(*key.look_up)) {
  if (key.integrates)
    integrated = integratedLook(*key.look_up);
  else if (traitsOf(key.mode).has_colors && !key.look_up->interpolates)
    packed = packedEntries(entries, kMostExponent);
  if (channels == Channels::kSeveral && !packed.entries.empty() && !key.look_up->labels)
    ramp = colorRamp(entries);
}

FrameTables::FrameTables(const FrameSetup& setup, const LookUpTables& look_up,
                         const uint64_t* light_squares) {
  const ModeTraits& traits = traitsOf(setup.mode);
  const bool colors = traits.has_colors;
  frame_.width = setup.size.width;
  frame_.height = setup.size.height;
  frame_.combining = traits.combining;
  frame_.on_planes = traits.on_planes;
  frame_.codes_depth = traits.codes_depth;
  frame_.type = setup.type;
  frame_.perspective = setup.projection == Projection::kPerspective;
  frame_.with_depth = colors && setup.with_depth;
  frame_.counts_taken = colors && setup.counts_taken && !setup.with_depth;
  frame_.labels = colors && setup.look_up->labels;
  frame_.shades_every_sample = setup.shades_every_sample;
  frame_.interpolates = setup.look_up->interpolates;
  frame_.lit = colors && setup.lit;
  if (traits.hides && setup.opacity_threshold < 1)
    frame_.box_opacity = static_cast<float>(setup.opacity_threshold);
  if (traits.hides && setup.skips) frame_.ray_opacity = kNothingMore;
  setRays(setup);
  setLookUp(look_up);
  // A ray that ends at a threshold shows where an opacity differs by rounding alone.
  if (look_up.ramp && setup.opacity_threshold >= 1) frame_.ramp = &*look_up.ramp;
  const auto [window_lo, window_hi] = setup.window;
  frame_.window_lo = static_cast<float>(window_lo);
  frame_.window_scale =
      static_cast<float>(window_lo == window_hi ? 0 : 1 / (window_hi - window_lo));
  frame_.attenuation = static_cast<float>(setup.attenuation * setup.slice_length);
  if (setup.has_surfaces) setSurfaces(*setup.look_up);
  setLights(setup, light_squares);
  if (colors) setRows(setup);
  if (setup.has_surfaces) setBeside();
}

void FrameTables::setRays(const FrameSetup& setup) {
  const RayGrid& rays = setup.rays;
  frame_.place_origin = asFloats(rays.origin0 - placeBase(setup));
  frame_.origin_dx = asFloats(rays.origin_dx);
  frame_.origin_dy = asFloats(rays.origin_dy);
  frame_.step0 = asFloats(rays.step0);
  frame_.step_dx = asFloats(rays.step_dx);
  frame_.step_dy = asFloats(rays.step_dy);
  frame_.first_slice = static_cast<float>(setup.first_slice);
  frame_.first_depth = static_cast<float>(setup.first_depth);
  frame_.depth_step = static_cast<float>(setup.depth_step);
  frame_.slice_length = static_cast<float>(setup.slice_length);
  if (setup.jitter > 0) {
    frame_.noise = blueNoise().data();
    frame_.jitter = static_cast<float>(setup.jitter);
  }
  if (const auto [near, far] = setup.shown_depths; setup.depth_cueing > 0 && far > near) {
    const double a_depth = setup.depth_cueing / (far - near);
    frame_.cue_start = static_cast<float>((setup.first_depth - near) * a_depth);
    frame_.cue_step = static_cast<float>(setup.depth_step * a_depth);
    frame_.cue_most = static_cast<float>(setup.depth_cueing);
  }
  frame_.planes_a_voxel = static_cast<float>(setup.planes_a_voxel);
  frame_.end_margin = static_cast<float>(endMargin(setup.planes_a_voxel));
  frame_.pixel_ray = {static_cast<float>(2 * setup.tan_half_x / setup.size.width),
                      static_cast<float>(-setup.tan_half_x),
                      static_cast<float>(2 * setup.tan_half_y / setup.size.height),
                      static_cast<float>(-setup.tan_half_y)};
  for (const ClipPlane& plane : setup.clip_planes) {
    const Float3 normal = asFloats(plane.normal);
    // Relative to origin0, so that single precision has digits enough.
    frame_.clip_plane[static_cast<size_t>(frame_.clip_planes++)] = {
        normal[0], normal[1], normal[2],
        static_cast<float>(plane.offset - dot(plane.normal, rays.origin0))};
  }
}

void FrameTables::setLookUp(const LookUpTables& tables) {
  const ValueRange range = tables.key.look_up->device_range;
  const size_t last_entry = tables.entries.size() / 4 - 1;
  const auto last = static_cast<double>(last_entry);
  const double per_value = range.hi > range.lo ? last / (range.hi - range.lo) : 0;
  frame_.entries = tables.entries.data();
  frame_.label_entries = tables.key.look_up->rgba.data();
  if (!tables.packed.entries.empty()) {
    frame_.packed_entries = tables.packed.entries.data();
    frame_.color_unit = tables.packed.color_unit;
    frame_.opacity_unit = tables.packed.opacity_unit;
  }
  if (const IntegratedLook& integrated = tables.integrated; !integrated.sums.empty()) {
    frame_.sums = integrated.sums.data();
    frame_.sums_last = static_cast<float>(integrated.entries() - 1);
    frame_.sums_alone = frame_.sums + integrated.sums.size() / 2;
    frame_.one_value = static_cast<float>(integrated.one_value);
    frame_.near_entry = static_cast<float>(integrated.near_entry);
    const bool has_factors = !tables.key.look_up->magnitudes.empty();
    // With factors, the exponent is of a unit length: the factor applies before the opacity is
    // corrected.
    frame_.sums_unit =
        static_cast<float>(integrated.unit * (has_factors ? 1 : tables.key.slice_length));
  }
  frame_.entry_scale = static_cast<float>(per_value);
  frame_.entry_offset = static_cast<float>(-range.lo * per_value);
  frame_.last_entry = static_cast<float>(last);
  frame_.least = static_cast<float>(range.lo);
  frame_.greatest = static_cast<float>(range.hi);
  if (const ExpectedLook* expected = tables.key.look_up->expected.get()) {
    const ValueRange values = expected->device_range;
    const double span = values.hi - values.lo;
    const double entries = span > 0 ? (expected->entries - 1) / span : 0;
    frame_.expected = expected->rgba.data();
    frame_.mean_scale = static_cast<float>(entries);
    frame_.mean_offset = static_cast<float>(-values.lo * entries);
    frame_.spread_scale = static_cast<float>(span > 0 ? 1 / span : 0);
    // The unit may be more than a float holds if the values fill the range of floats.
    frame_.spread_unit =
        static_cast<float>(std::min(span, double{std::numeric_limits<float>::max()}));
    frame_.expected_entries = expected->entries;
    frame_.expected_rows = expected->rows;
  }
  frame_.least_visible = static_cast<float>(tables.visible[0]);
  frame_.most_visible = static_cast<float>(tables.visible[1]);
}

void FrameTables::setSurfaces(const LookUp& look_up) {
  SLUICE_CHECK_LE(look_up.surfaces.size(), kMostSurfaces);
  for (const SurfaceLevel& surface : look_up.surfaces) {
    const auto i = static_cast<size_t>(frame_.surfaces++);
    frame_.level[i] = static_cast<float>(surface.level);
    frame_.surface_opacity[i] = static_cast<float>(surface.opacity);
    for (size_t c = 0; c < 3; ++c)
      frame_.surface_rgb[c][i] = static_cast<float>(surface.rgb[static_cast<int>(c)]);
  }
  frame_.has_opacities = showsOpacities(look_up);
}

// The same frame with its surfaces alone, and with the opaque ones alone.
void FrameTables::setBeside() {
  at_seam_ = frame_;
  // Opacities are drawn in the cells of a block alone.
  at_seam_.has_opacities = at_seam_.counts_taken = false;
  beside_ = at_seam_;
  beside_.surfaces = 0;
  for (size_t i = 0; i < static_cast<size_t>(frame_.surfaces); ++i) {
    if (frame_.surface_opacity[i] < 1) continue;
    const auto to = static_cast<size_t>(beside_.surfaces++);
    beside_.level[to] = frame_.level[i];
    beside_.surface_opacity[to] = frame_.surface_opacity[i];
    for (size_t c = 0; c < 3; ++c) beside_.surface_rgb[c][to] = frame_.surface_rgb[c][i];
  }
  frame_.beside = &beside_;
  frame_.at_seam = &at_seam_;
}

void FrameTables::setLights(const FrameSetup& setup, const uint64_t* light_squares) {
  const Lighting& lighting = setup.lighting;
  for (size_t i = 0; i < lighting.lights.size(); ++i) {
    const Light& light = lighting.lights[i];
    frame_.toward[i] = asFloats(light.toward * (light.strength * lighting.diffuse));
    frame_.halfway[i] = asFloats(normalized(light.toward + Vec3d{0, 0, 1}));
    frame_.specular[i] = static_cast<float>(light.strength * lighting.specular);
    frame_.even_diffuse[i] = static_cast<float>(evenDiffuse(lighting, light));
    frame_.even_specular[i] = static_cast<float>(evenSpecular(lighting, light));
  }
  frame_.ambient = static_cast<float>(lighting.ambient);
  frame_.flat = static_cast<float>(setup.flat);
  frame_.shininess = static_cast<float>(lighting.shininess);
  frame_.whole_shininess = lighting.wholeShininess();
  frame_.key_share = static_cast<float>(lighting.keyShare());
  if (!frame_.lit || setup.light == nullptr) return;
  const Vec3i texels = setup.light->dims;
  // A square of four texels is one number of 64 bits, see light_squares.h.
  const auto texel_bytes =
      static_cast<int64_t>(light_squares != nullptr ? sizeof(uint64_t) : 2 * sizeof(uint16_t));
  frame_.light = light_squares != nullptr
                     ? reinterpret_cast<const std::byte*>(light_squares)
                     : reinterpret_cast<const std::byte*>(setup.light->texels.data());
  frame_.light_in_squares = light_squares != nullptr;
  frame_.key_light_varies = setup.light->key_varies;
  frame_.other_light_varies = setup.light->other_varies;
  frame_.light_hi = asFloats(toDouble(texels - Vec3i{1, 1, 1}));
  frame_.light_last = asFloats(toDouble(texels - Vec3i{2, 2, 2}));
  frame_.light_stride = asFloats(toDouble(Vec3i{1, texels.x, texels.x * texels.y} * texel_bytes));
}

void FrameTables::setRows(const FrameSetup& setup) {
  const std::vector<double>& magnitudes = setup.look_up->magnitudes;
  if (magnitudes.empty()) return;
  frame_.rows = static_cast<int>(magnitudes.size());
  frame_.factor_entries = static_cast<int>(setup.look_up->factors.size() / magnitudes.size());
  // Rows of factors hold opacities of a unit length, which are corrected after the factor.
  frame_.corrects = frame_.perspective || setup.slice_length != 1;
  for (size_t row = 0; row < magnitudes.size(); ++row) {
    const double next = magnitudes[std::min(row + 1, magnitudes.size() - 1)];
    const double distance = next - magnitudes[row];
    row_starts_.push_back(static_cast<float>(magnitudes[row]));
    row_growths_.push_back(static_cast<float>(distance > 0 ? 1 / distance : 0));
  }
  frame_.factors = setup.look_up->factors.data();
  frame_.row_starts = row_starts_.data();
  frame_.row_growths = row_growths_.data();
}

}  // namespace sluice

#include "src/gl/shaders/shading.h"

#include <algorithm>
#include <cmath>

#include "src/device/pictures/depth_code.h"
#include "src/device/shading/look_up_texels.h"
#include "src/device/shading/rough_light.h"

namespace sluice {
namespace {

// The cosines between the axes y and z, z and x, x and y.
Vec3d axisCosines(const FrameSetup& setup) {
  Vec3d cosines;
  for (size_t a = 0; a < 3; ++a)
    cosines[static_cast<int>(a)] = dot(normalized(setup.camera_gradient[(a + 1) % 3]),
                                       normalized(setup.camera_gradient[(a + 2) % 3]));
  return cosines;
}

// Products of each axis' direction with one.
Vec3d along(const FrameSetup& setup, Vec3d direction) {
  const auto& axes = setup.camera_gradient;
  return {dot(axes[0], direction), dot(axes[1], direction), dot(axes[2], direction)};
}

class Floats {
 public:
  Floats& add(double v) {
    values_.push_back(static_cast<float>(v));
    return *this;
  }
  Floats& add(Vec3d v) { return add(v.x).add(v.y).add(v.z); }
  const float* data() const { return values_.data(); }

 private:
  std::vector<float> values_;
};

// Four numbers for each row: its magnitude, 1 / the distance to the next row, its factor, and by
// how much the next row's factor is greater. Only the first entry's factors are read.
Floats rowsOf(const FrameSetup& setup) {
  const std::vector<double>& magnitudes = setup.look_up->magnitudes;
  const std::vector<float>& factors = setup.look_up->factors;
  const size_t rows = magnitudes.size(), entries = factors.size() / rows;
  const double scale = valueScale(setup.type);
  Floats result;
  for (size_t row = 0; row < rows; ++row) {
    const size_t next = std::min(row + 1, rows - 1);
    const double distance = (magnitudes[next] - magnitudes[row]) / scale;
    const double factor = factors[row * entries];
    result.add(magnitudes[row] / scale)
        .add(distance > 0 ? 1 / distance : 0)
        .add(factor)
        .add(factors[next * entries] - factor);
  }
  return result;
}

void setLights(const FrameSetup& setup, GlProgram& program) {
  const Lighting& lighting = setup.lighting;
  Floats toward, halfway, reflection, even;
  for (const Light& light : lighting.lights) {
    toward.add(along(setup, light.toward) * (light.strength * lighting.diffuse));
    halfway.add(along(setup, normalized(light.toward + Vec3d{0, 0, 1})));
    reflection.add(light.strength * lighting.specular);
    even.add(evenDiffuse(lighting, light));
  }
  for (const Light& light : lighting.lights) even.add(evenSpecular(lighting, light));
  // The gradient of labels is one of opacities, which have no scale.
  reflection.add(lighting.ambient)
      .add(setup.look_up->labels ? setup.flat : setup.flat / valueScale(setup.type));
  program.set3("index_toward", toward.data(), 2);
  program.set3("index_halfway", halfway.data(), 2);
  program.set4("view_reflection", reflection.data(), 1);
  program.set4("even_light", even.data(), 1);
  program.set("rough_parts", Vec3d{kSpreadPart, -kSlopePart, kNoisePart});
  program.set("shininess", lighting.shininess);
  program.set("key_share", lighting.keyShare());
}

// Light on texels with spreads needs these, see rough_light.h.
void setEdges(GlProgram& program) {
  constexpr double kSharpRate = 1 / (kSharpShare - kSoftShare);
  program.set("here_parts", Vec3d{kEvenPart, kOwnPart, kEdgePart});
  program.set("edge_parts", Vec3d{kEdgeVoxels, kSharpRate, -kSoftShare * kSharpRate});
  const Floats least =
      Floats().add(kLeastPart).add(kLeastProduct).add(kLeastHeight).add(kLeastLayer);
  program.set4("least_parts", least.data(), 1);
}

void setVisible(const FrameSetup& setup, GlProgram& program) {
  // Hardware interpolates with eight bits, or as exactly as it likes. This is some times its error,
  // since the range of all values may be an estimate from a coarse level.
  constexpr double kFilterShare = 1.0 / 32;
  const LookUp& look_up = *setup.look_up;
  const auto [least, greatest] = visibleValues(look_up);
  const double scale = valueScale(setup.type);
  program.set2("visible_texels", least / scale, greatest / scale);
  const ValueRange &shown = look_up.device_range, &all = look_up.volume_range;
  const double span = std::max(shown.hi, all.hi) - std::min(shown.lo, all.lo);
  program.set("filter_tie", span * kFilterShare / scale);
}

// The surfaces that a program draws.
std::vector<SurfaceLevel> surfacesOf(const FrameSetup& setup, bool only_opaque) {
  std::vector<SurfaceLevel> surfaces = setup.look_up->surfaces;
  if (only_opaque)
    std::erase_if(surfaces, [](const SurfaceLevel& each) { return each.opacity < 1; });
  return surfaces;
}

void setSurfaces(const FrameSetup& setup, bool only_opaque, GlProgram& program) {
  const double scale = valueScale(setup.type);
  Floats levels, colors;
  const std::vector<SurfaceLevel> surfaces = surfacesOf(setup, only_opaque);
  for (const SurfaceLevel& surface : surfaces) {
    levels.add(surface.level / scale);
    colors.add(surface.rgb * surface.opacity).add(surface.opacity);
  }
  const auto count = static_cast<int>(surfaces.size());
  program.set1("surface_levels", levels.data(), count);
  program.set4("surface_colors", colors.data(), count);
  program.set("place_origin", setup.rays.origin0 - placeBase(setup));
}

// Sets the members that depend on how the frame is lit and on factors.
void chooseShading(const FrameSetup& setup, ShaderVariant& variant) {
  if (setup.has_surfaces) {
    variant.surfaces = static_cast<int>(setup.look_up->surfaces.size());
    variant.has_opacities = showsOpacities(*setup.look_up);
    variant.goes_ahead = true;
  }
  variant.lit = setup.lit;
  variant.shininess = setup.lit ? setup.lighting.wholeShininess() : 0;
  variant.light_volume = setup.lit && setup.light != nullptr;
  const LookUp& look_up = *setup.look_up;
  variant.gradient_rows = static_cast<int>(look_up.magnitudes.size());
  variant.factor_table = look_up.factors.size() > look_up.magnitudes.size();
  variant.corrects = (variant.gradient_rows > 0 || variant.labels) &&
                     (variant.perspective || setup.slice_length != 1);
  // Between finite values the hardware's are off by little, but not next to those that stand for
  // infinities or NaN.
  variant.rough_first = variant.fetches && !variant.floats && !setup.shades_every_sample;
  if (!setup.lit && variant.gradient_rows == 0) return;
  variant.goes_ahead = variant.surfaces > 0 || !setup.shades_every_sample;
  const Vec3d cosines = axisCosines(setup);
  constexpr double kRounding = 1e-6;
  variant.oblique =
      std::max({std::abs(cosines.x), std::abs(cosines.y), std::abs(cosines.z)}) > kRounding;
}

}  // namespace

double valueScale(DeviceType type) {
  switch (type) {
    case DeviceType::kU8:
      return 255;
    case DeviceType::kU16:
      return 65535;
    case DeviceType::kF32:
      break;
  }
  return 1;
}

ShaderVariant frameVariant(const FrameSetup& setup, bool fetches) {
  const ModeTraits& traits = traitsOf(setup.mode);
  const bool colors = traits.has_colors;
  ShaderVariant variant{.combining = traits.combining,
                        .perspective = (colors || traits.combining == Combining::kAttenuated) &&
                                       setup.projection == Projection::kPerspective,
                        .with_depth = colors && setup.with_depth,
                        .stops_early = traits.hides && setup.opacity_threshold < 1,
                        .floats = setup.type == DeviceType::kF32,
                        .counts_taken = colors && setup.counts_taken && !setup.with_depth,
                        .counts = false,
                        .clip_planes = static_cast<int>(setup.clip_planes.size()),
                        .labels = colors && setup.look_up->labels,
                        .label_table = setup.look_up->labels,
                        .planes = traits.on_planes,
                        .codes_depth = traits.codes_depth,
                        .integrates = setup.integrates,
                        .cues_depth = setup.depth_cueing > 0,
                        .jitters = setup.jitter > 0,
                        .fetches = fetches};
  if (colors) chooseShading(setup, variant);
  return variant;
}

ShaderVariant boxVariant(ShaderVariant frame, Vec3d scale, bool has_spread) {
  frame.scaled = scale != Vec3d{1, 1, 1};
  frame.shares = has_spread && frame.labels;
  frame.corrects = frame.corrects || frame.shares;
  frame.spread = has_spread && !frame.labels && frame.combining == Combining::kBlend;
  // A spread may show where the value does not.
  frame.rough_first = frame.rough_first && !frame.spread;
  return frame;
}

ShaderVariant besideVariant(const FrameSetup& setup, ShaderVariant of_box, const BoxDraw& box) {
  of_box.fades = box.fade.has_value();
  if (!box.beside) return of_box;
  of_box.only_opaque = !box.fade;
  of_box.has_opacities = false;
  of_box.surfaces = static_cast<int>(surfacesOf(setup, of_box.only_opaque).size());
  return of_box;
}

ShaderVariant withJoined(ShaderVariant of_box, const std::vector<bool>& have_spreads) {
  of_box.joined = static_cast<int>(have_spreads.size());
  for (size_t i = 0; i < have_spreads.size(); ++i)
    of_box.joined_spreads |= have_spreads[i] ? 1 << i : 0;
  return of_box;
}

ShaderVariant viewVariant(const ShaderVariant& variant) {
  return {.perspective = variant.perspective,
          .with_depth = variant.with_depth,
          .stops_early = variant.stops_early,
          .counts_taken = variant.counts_taken,
          .clip_planes = variant.clip_planes,
          .cues_depth = variant.cues_depth,
          .jitters = variant.jitters};
}

void setView(const FrameSetup& setup, PictureRows rows, GlProgram& program) {
  const RayGrid& rays = setup.rays;
  program.set("first_row", static_cast<double>(rows.lo));
  program.set("view_origin_dx", rays.origin_dx);
  program.set("view_origin_dy", rays.origin_dy);
  program.set("view_step0", rays.step0);
  program.set("view_step_dx", rays.step_dx);
  program.set("view_step_dy", rays.step_dy);
  program.set("view_first_slice", static_cast<double>(setup.first_slice));
  program.set("planes_a_voxel", static_cast<double>(setup.planes_a_voxel));
  program.set("end_margin", endMargin(setup.planes_a_voxel));
  program.set("opacity_threshold", setup.opacity_threshold);
  program.set("view_first_depth", setup.first_depth);
  program.set("view_depth_step", setup.depth_step);
  const double ux = 2 * setup.tan_half_x / setup.size.width;
  const double vy = 2 * setup.tan_half_y / setup.size.height;
  const Floats pixel_ray = Floats().add(ux).add(-setup.tan_half_x).add(vy).add(-setup.tan_half_y);
  program.set4("view_pixel_ray", pixel_ray.data(), 1);
  if (setup.depth_cueing > 0) setCueing(setup, program);
  Floats planes;
  for (const ClipPlane& plane : setup.clip_planes)
    // Positions count from the rays' common origin: far from it they lose digits in single
    // precision.
    planes.add(plane.normal).add(plane.offset - dot(plane.normal, rays.origin0));
  if (!setup.clip_planes.empty())
    program.set4("clip_planes", planes.data(), static_cast<int>(setup.clip_planes.size()));
}

void setShading(const FrameSetup& setup, const ShaderVariant& variant, GlProgram& program) {
  if (variant.goes_ahead || variant.rough_first) setVisible(setup, program);
  if (variant.surfaces > 0) setSurfaces(setup, variant.only_opaque, program);
  program.set("slice_length", setup.slice_length);
  if (!variant.lit && variant.gradient_rows == 0) return;
  const auto& axes = setup.camera_gradient;
  program.set("index_slope", Vec3d{length(axes[0]), length(axes[1]), length(axes[2])});
  program.set("axis_cosines", axisCosines(setup));
  if (variant.spread) setEdges(program);
  if (variant.lit) setLights(setup, program);
  if (variant.gradient_rows == 0) return;
  const Floats rows = rowsOf(setup);
  program.set4("first_rows", rows.data(), 1);
  program.set4("gradient_rows", rows.data(), variant.gradient_rows);
}

void setFade(const BoxDraw& box, GlProgram& program) {
  if (!box.fade) return;
  Floats start, slope;
  for (const size_t upper : {size_t{0}, size_t{3}})
    for (int a = 0; a < 3; ++a) {
      const size_t i = upper + static_cast<size_t>(box.texels.axes[static_cast<size_t>(a)]);
      const double a_texel = box.fade->slope[i] / box.texels.scale[a];
      start.add(box.fade->start[i] - a_texel * box.texels.offset[a]);
      slope.add(a_texel);
    }
  program.set1("fade_start", start.data(), 6);
  program.set1("fade_slope", slope.data(), 6);
}

void setCueing(const FrameSetup& setup, GlProgram& program) {
  const auto [near, far] = setup.shown_depths;
  const double a_depth = far > near ? setup.depth_cueing / (far - near) : 0;
  program.set("depth_cue", Vec3d{(setup.first_depth - near) * a_depth, setup.depth_step * a_depth,
                                 setup.depth_cueing});
}

void setWindow(const FrameSetup& setup, GlProgram& program) {
  const ModeTraits& traits = traitsOf(setup.mode);
  if (traits.combining != Combining::kAttenuated && !traits.codes_depth) return;
  const auto [lo, hi] = setup.window;
  const double scale = valueScale(setup.type);
  program.set("window_texels", Vec3d{lo / scale, lo == hi ? 0 : scale / (hi - lo),
                                     setup.attenuation * setup.slice_length});
  if (!traits.codes_depth) return;
  // For positions from the rays' common origin.
  const std::array<double, 4> row = depthRow(setup);
  const Vec3d along{row[0], row[1], row[2]};
  const Floats line = Floats().add(along).add(row[3] + dot(along, setup.rays.origin0));
  program.set4("depth_row", line.data(), 1);
}

}  // namespace sluice

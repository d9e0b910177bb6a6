#include "src/gl/shaders/shader_text.h"

namespace sluice {

const char* const kColorText = R"(
uniform sampler2D look_up;
#if GRADIENT_ROWS > 0 || LABELS
uniform float slice_length;  // unit lengths between samples

// The opacity of `lengths` unit lengths from that of one.
float corrected(float opacity, float lengths) {
#if CORRECTS
  return opacity < 1.0 ? 1.0 - exp2(lengths * log2(1.0 - opacity)) : 1.0;
#else
  return opacity;
#endif
}
#endif

// Unit lengths between samples that are this many slices apart.
float voxelLengths(float ray_length) {
#if GRADIENT_ROWS > 0 || LABELS
  return slice_length * ray_length;
#else
  return 1.0;
#endif
}

#if LABEL_TABLE
#define LABEL_ROW 4096
uniform int label_entries;
vec4 labelEntry(int i) {
  i = clamp(i, 0, label_entries - 1);
  return texelFetch(look_up, ivec2(i % LABEL_ROW, i / LABEL_ROW), 0);
}
#if LABELS
// Not premultiplied, with the opacity of a unit length.
vec4 labelColor(float entry) { return labelEntry(int(entry * float(label_entries))); }
#else
// Between two entries, which may lie in two rows, so that the hardware cannot interpolate.
vec4 betweenLabels(float entry) {
  float place = clamp(entry * float(label_entries) - 0.5, 0.0, float(label_entries - 1));
  int i = int(place);
  return mix(labelEntry(i), labelEntry(i + 1), place - float(i));
}
#endif
#endif

#if GRADIENTS
#if OBLIQUE
uniform vec3 axis_cosines;  // between y and z, z and x, x and y
#endif

// The square of the gradient's length in the world.
float squareOf(vec3 difference) {
  vec3 g = difference * slope;
  float squared = dot(g, g);
#if OBLIQUE
  g = turn == 2 ? g : turn == 0 ? g.zxy : g.yzx;
  squared += 2.0 * dot(axis_cosines, g.yzx * g.zxy);
#endif
  return squared;
}
#endif

#if GRADIENT_ROWS > 0
#if GRADIENT_ROWS > 2
uniform vec4 gradient_rows[GRADIENT_ROWS];  // as `ramp`, from each row to the next
#endif
#if FACTOR_TABLE
uniform sampler2D factors;
#endif

float factorOf(float magnitude, float entry) {
  float row = clamp((magnitude - ramp.x) * ramp.y, 0.0, 1.0);
  float factor = ramp.z + row * ramp.w;
#if GRADIENT_ROWS > 2
  for (int i = 1; i + 1 < GRADIENT_ROWS; ++i) {
    float passed = clamp((magnitude - gradient_rows[i].x) * gradient_rows[i].y, 0.0, 1.0);
    row += passed;
    factor += passed * gradient_rows[i].w;
  }
#endif
#if FACTOR_TABLE
  factor = textureLod(factors, vec2(entry, (row + 0.5) / float(GRADIENT_ROWS)), 0.0).r;
#endif
  return factor;
}
#endif

#if SPREAD
uniform sampler2D expected;
uniform float expected_length;

// The colour of a texel with a spread, premultiplied, over a way of `lengths` slices whose opacity
// is multiplied by `factor` first: see ExpectedLook. `exact` is the same without spread.
vec4 expectedColor(float value, float share, float factor, float lengths, vec4 exact) {
  float row = sqrt(share) * expected_line.w;
  vec2 at = vec2(value * expected_line.x + expected_line.y,
                 (max(row - 1.0, 0.0) + 0.5) / expected_line.w);
  vec4 mean = textureLod(expected, clamp(at, vec2(0.0), vec2(1.0)), 0.0);
  float opacity = mean.a * factor;
  float a = opacity < 1.0 ? 1.0 - exp2(lengths * expected_length * log2(1.0 - opacity)) : 1.0;
  return mix(exact, vec4(mean.rgb * (a / max(mean.a, 1e-20)), a), min(row, 1.0));
}
#endif

#if INTEGRATES
uniform isampler2D sums;   // IntegratedLook
// The last entry; the exponent of slice_length, or of a unit length with factors, that a sum of 1
// stands for.
uniform vec2 sums_line;
uniform vec2 one_value;    // IntegratedLook::one_value and near_entry

// A value's place among the entries, and the sums below it: those below the entry before it, and the
// part of their growth up to the next entry that lies below the place.
struct SumsAt {
  float place;
  ivec4 below;
  vec4 part;
};
SumsAt sumsAt(float value) {
  SumsAt result;
  result.place = clamp(value * entry_scale + entry_offset, -4e6, 4e6);
  float first = clamp(floor(result.place), 0.0, sums_line.x - 1.0);
  result.below = texelFetch(sums, ivec2(int(first), 0), 0);
  result.part = (result.place - first) *
                vec4(texelFetch(sums, ivec2(int(first) + 1, 0), 0) - result.below);
  return result;
}

// The numbers of one value.
vec4 oneValueAt(float place) {
  place = clamp(place, 0.0, sums_line.x);
  float first = min(floor(place), sums_line.x - 1.0);
  float part = clamp((place - first - one_value.y) / (1.0 - 2.0 * one_value.y), 0.0, 1.0);
  return mix(vec4(texelFetch(sums, ivec2(int(first), 1), 0)),
             vec4(texelFetch(sums, ivec2(int(first) + 1, 1), 0)), part);
}

// The mean of the values from one place to another: colour, not premultiplied, and the exponent of
// what passes.
vec4 segmentColor(SumsAt front, SumsAt back) {
  float way = back.place - front.place;
  // One value, or values beyond one end of the table, which all look the same.
  bool even = abs(way) < one_value.x || min(front.place, back.place) >= sums_line.x ||
              max(front.place, back.place) <= 0.0;
  vec4 sum = vec4(back.below - front.below) + (back.part - front.part);
  vec4 mean = sum / (even ? 1.0 : way);
  // A loop, since software GL skips no `if`.
  for (bool again = even; again; again = false) mean = oneValueAt(0.5 * (front.place + back.place));
  float extinction = max(mean.a, 0.0);
  return vec4(clamp(mean.rgb / max(extinction, 1e-20), 0.0, 1.0), extinction * sums_line.y);
}
#endif

#if LIT
#if SHININESS == 0
uniform float shininess;
#endif
vec2 shine(vec2 x) {
#if SHININESS > 0
  // Software GL takes long over a logarithm.
  vec2 result = vec2(1.0);
  for (int n = SHININESS; n > 0; n /= 2) {
    if ((n & 1) != 0) result *= x;
    x *= x;
  }
  return result;
#else
  return pow(x, vec2(shininess));
#endif
}

#if SPREAD
// Factors of the squares of a spread, a difference and noise: kSpreadPart, kSlopePart, kNoisePart.
uniform vec3 rough_parts;
uniform vec4 even_light;   // evenDiffuse() and evenSpecular() of each light

// The square of the slopes in all directions, for a spread, a difference and noise in one unit.
float roughOf(vec3 difference, float spread, float noise) {
  vec2 squares = vec2(spread * spread, dot(difference, difference));
  float of_voxels = texelLength() * noise;
  return dot(slope, slope) *
         (max(dot(rough_parts.xy, squares), 0.0) + rough_parts.z * of_voxels * of_voxels);
}
#endif

// `color` premultiplied; `squared`, `rough` (0 without spreads) and `flatness` squares of lengths
// of gradients in one unit; `counts`: what counts of `squared`, and the share of that whose light is
// seen; `light_at`: the place in the light volume.
vec4 shade(vec4 color, vec3 difference, float squared, vec2 counts, float rough, float flatness,
           vec3 light_at) {
  float to_unit = inversesqrt(max(squared, 1e-37));
  vec2 facing = abs(vec2(dot(difference, toward0), dot(difference, toward1)));
  vec2 mirrored = abs(vec2(dot(difference, halfway0), dot(difference, halfway1)));
#if LIGHT_VOLUME
  vec2 arriving = textureLod(light, light_at, 0.0).rg;
  facing *= arriving;
  vec3 plain = color.rgb * mix(arriving.y, arriving.x, key_share);
#else
  const vec2 arriving = vec2(1.0);
  vec3 plain = color.rgb;
#endif
  float diffuse = to_unit * (facing.x + facing.y);
  float specular = dot(reflection.xy * arriving, shine(to_unit * mirrored));
  float seen = squared;
#if SPREAD
  float counted = squared * counts.x;
  squared = counted + rough;
  seen = counted * counts.y + rough;
  vec2 even = vec2(dot(even_light.xy, arriving), dot(even_light.zw, arriving));
  vec2 both = mix(vec2(diffuse, specular), even, rough / max(squared, 1e-37));
  diffuse = both.x;
  specular = both.y;
#endif
  vec3 lit = color.rgb * (reflection.z * arriving.y + diffuse) + color.a * specular;
  return vec4(mix(plain, lit, seen / max(squared + flatness, 1e-37)), color.a);
}
#endif

// The place of a value in the look-up, and the colour there.
float entryOf(float value) {
  float entry = value * entry_scale + entry_offset;
#if FLOATS
  entry = clamp(entry, 0.0, 1.0);  // drivers may wrap where a coordinate is beyond integers
#endif
  return entry;
}
vec4 entryColor(float value, float entry) {
#if FLOATS
  if (IS_NO_NUMBER(vec3(value)).x) return vec4(0.0);
#endif
#if LABELS
  return labelColor(entry);
#elif LABEL_TABLE
  return betweenLabels(entry);
#else
  return textureLod(look_up, vec2(entry, 0.5), 0.0);
#endif
}
)";

const char* const kShownColorText = R"(
#if COMBINING == 0
// The colour of a composite sample, premultiplied: `color` is that of its look-up. `part`: what
// shows of the label. `ray_length`: slices from sample to sample; `voxel_lengths`: the same in unit
// lengths, for gradient factors and labels.
vec4 shownColor(vec4 color, float value, float part, float entry, vec3 at, float ray_length,
                float voxel_lengths, vec3 light_at) {
#if SPREAD
  float share = spreadShareAt(at);
#endif
#if GRADIENTS
#if LABELS && GRADIENT_ROWS == 0
  vec3 difference = labelSlopes(at);
#elif SPREAD
  WideSlopes wide = wideSlopes(at, share);
  vec3 difference = wide.slopes;
#else
  vec3 difference = differenceAt(at);
#endif
  float unit = 1.0;
#if SPREAD
  float spread = wide.spread / max(expected_line.z, 1e-37);
  float noise = wide.noise / max(expected_line.z, 1e-37);
#endif
#if FLOATS
  // In units of the steepest axis, since squares of the values themselves may overflow.
  unit = max(max(abs(difference.x), max(abs(difference.y), abs(difference.z))), 1e-37);
#if SPREAD
  unit = max(unit, max(spread, noise));
#endif
  difference /= unit;
#endif
  float squared = squareOf(difference);
#endif
  float factor = 1.0;
#if GRADIENT_ROWS > 0
#if INTEGRATES
  color.a = 1.0 - exp2(-color.a);
#endif
  factor = factorOf(unit * sqrt(squared), entry);
#endif
#if SHARES
  color.a = sharedOpacity(color.a * factor, part, voxel_lengths);
  color.rgb *= color.a;
#elif GRADIENT_ROWS > 0 || LABELS
  color.a = corrected(color.a * factor, voxel_lengths);
  color.rgb *= color.a;
#elif INTEGRATES
  color.a = 1.0 - exp2(-color.a * ray_length);
  color.rgb *= color.a;
#elif PERSPECTIVE
  color.a = 1.0 - exp2(color.a * ray_length);
  color.rgb *= color.a;
#endif
#if SPREAD
  color = expectedColor(value, share, factor, ray_length, color);
#if FLOATS
  if (IS_NO_NUMBER(vec3(value)).x) color = vec4(0.0);
#endif
#endif
#if LIT
#if LABELS && GRADIENT_ROWS > 0
  difference = labelSlopes(at);
  squared = squareOf(difference);
  unit = 1.0;
#endif
  float flatness = reflection.w / unit;
#if SPREAD
  float rough = roughOf(difference, spread / unit, noise / unit);
  vec2 counts = vec2(wide.here, wide.seen);
#else
  const float rough = 0.0;
  const vec2 counts = vec2(1.0);
#endif
  color = shade(color, difference, squared, counts, rough, flatness * flatness, light_at);
#endif
  return color;
}
#endif
)";

}  // namespace sluice

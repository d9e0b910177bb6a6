#include "src/gl/shaders.h"

#include <fmt/format.h>

namespace sluice {
namespace {

constexpr const char* kVersion = "#version 330 core\n";

// What a fragment needs of the box and of the frame. All of it comes as flat inputs, the frame's
// numbers too: software GL reads a uniform anew for each pixel, in every turn of a loop, but an
// input that is flat once for all the pixels that it draws together. GL 3.3 lets 60 components
// pass; those that a variant does not read do not count.
constexpr const char* kInputs = R"(
FLAT vec3 box_lo, box_hi, texel0, texel_dx, texel_dy;
FLAT int first_k, turn;
FLAT vec3 texel_size;         // 1 / texels of the chunk
FLAT vec3 origin_dx, origin_dy, step0, step_dx, step_dy;
FLAT float first_slice;
FLAT float entry_scale, entry_offset, stop_opacity;
FLAT float least, greatest;   // texel values of the first and the last entry
FLAT float first_depth, depth_step;
FLAT vec4 pixel_ray;          // u tan x = x * .x + .y, v tan y = y * .z + .w
)";

constexpr const char* kVertex = R"(
uniform samplerBuffer boxes;
uniform vec3 chunk_texel_size;
uniform vec3 view_origin_dx, view_origin_dy, view_step0, view_step_dx, view_step_dy;
uniform float view_first_slice, view_first_depth, view_depth_step;
uniform vec4 view_pixel_ray;
uniform vec4 entries;      // scale, offset, least, greatest
uniform float opacity_threshold;
void main() {
  int at = gl_InstanceID * 13;
  vec4 corner = texelFetch(boxes, at + gl_VertexID);
  vec4 lo = texelFetch(boxes, at + 8), hi = texelFetch(boxes, at + 9);
  box_lo = lo.xyz;
  box_hi = hi.xyz;
  first_k = int(lo.w);
  turn = int(hi.w);
  texel_size = chunk_texel_size;
  texel0 = texelFetch(boxes, at + 10).xyz * texel_size;
  texel_dx = texelFetch(boxes, at + 11).xyz * texel_size;
  texel_dy = texelFetch(boxes, at + 12).xyz * texel_size;
  origin_dx = view_origin_dx;
  origin_dy = view_origin_dy;
  step0 = view_step0;
  step_dx = view_step_dx;
  step_dy = view_step_dy;
  first_slice = view_first_slice;
  first_depth = view_first_depth;
  depth_step = view_depth_step;
  pixel_ray = view_pixel_ray;
  entry_scale = entries.x;
  entry_offset = entries.y;
  least = entries.z;
  greatest = entries.w;
  stop_opacity = opacity_threshold;
  gl_Position = vec4(corner.xy, 0.0, corner.z);
}
)";

// The slices of this pixel's ray inside the box: [from, to).
constexpr const char* kInterval = R"(
layout(location = 0) out vec4 result;
#if CLIP_PLANES > 0
uniform vec4 clip_planes[CLIP_PLANES];
#endif

// The first slice past the face at distance t. Both boxes at a face compute the same number.
vec3 sliceAt(vec3 t, vec3 step) {
  return mix(floor(t) + 1.0, ceil(t), greaterThan(step, vec3(0.0)));
}

ivec2 slices(vec3 origin, vec3 step) {
  vec3 safe = mix(step, vec3(1e-12), lessThan(abs(step), vec3(1e-12)));
  vec3 at_lo = sliceAt((box_lo - origin) / safe - 0.5, safe);
  vec3 at_hi = sliceAt((box_hi - origin) / safe - 0.5, safe);
  vec3 enter = min(at_lo, at_hi), leave = max(at_lo, at_hi);
  float from = max(max(enter.x, enter.y), max(enter.z, first_slice));
  float to = min(leave.x, min(leave.y, leave.z));
#if CLIP_PLANES > 0
  for (int i = 0; i < CLIP_PLANES; ++i) {
    float along = dot(clip_planes[i].xyz, step);
    float t = (clip_planes[i].w - dot(clip_planes[i].xyz, origin)) /
              (abs(along) < 1e-12 ? 1e-12 : along) - 0.5;
    if (along < 0.0) from = max(from, ceil(t));
    else to = min(to, floor(t) + 1.0);
  }
#endif
  // A ray beside the box along an axis that it does not move on enters at infinity.
  if (from >= to) return ivec2(0);
  return ivec2(int(from), int(to));
}
)";

constexpr const char* kCount = R"(
void main() {
  vec2 pixel = gl_FragCoord.xy;
  ivec2 range = slices(pixel.x * origin_dx + pixel.y * origin_dy,
                       step0 + pixel.x * step_dx + pixel.y * step_dy);
  if (range.x >= range.y) discard;
  result = vec4(float(range.y - range.x));
}
)";

constexpr const char* kSample = R"(
uniform sampler3D chunk;
uniform sampler2D look_up;
// Texels below are, or are interpolated with, one that stands for NaN.
#define IS_NO_NUMBER(v) lessThan(v, vec3(-2e30))
#if WITH_DEPTH
layout(location = 1) out vec4 depth_sum;  // opacity times depth, and opacity to blend by
#endif
#if COUNTS_TAKEN
layout(location = 1) out vec4 taken;  // samples; of opacity 0, so that they add up
#endif
#if GRADIENTS
uniform vec3 camera_x, camera_y, camera_z;

vec3 indexOrder(vec3 v) { return turn == 2 ? v : turn == 0 ? v.zxy : v.yzx; }

// Camera space, in units of the steepest axis' difference, since squares of the values themselves may
// overflow. Both are 0 where the volume is flat.
vec3 gradientAt(vec3 at, out float steepest) {
  vec2 n = vec2(1.0, 0.0);
  vec3 after = vec3(textureLod(chunk, at + n.xyy * texel_size, 0.0).r,
                    textureLod(chunk, at + n.yxy * texel_size, 0.0).r,
                    textureLod(chunk, at + n.yyx * texel_size, 0.0).r);
  vec3 before = vec3(textureLod(chunk, at - n.xyy * texel_size, 0.0).r,
                     textureLod(chunk, at - n.yxy * texel_size, 0.0).r,
                     textureLod(chunk, at - n.yyx * texel_size, 0.0).r);
  vec3 difference = 0.5 * (after - before);
#if FLOATS
  // A neighbour that is no number says nothing of the slope along its axis.
  difference = mix(difference, vec3(0.0), IS_NO_NUMBER(min(after, before)));
#endif
  steepest = max(abs(difference.x), max(abs(difference.y), abs(difference.z)));
  difference = steepest > 0.0 ? indexOrder(difference / steepest) : vec3(0.0);
  return difference.x * camera_x + difference.y * camera_y + difference.z * camera_z;
}
#endif

#if GRADIENT_ROWS > 0
// Between rows i and i + 1: the magnitude of row i, 1 / the distance to the next, and by how much
// the factor grows where it depends on no value.
uniform vec3 gradient_rows[GRADIENT_ROWS];
uniform float first_factor, slice_length;
#if FACTOR_TABLE
uniform sampler2D factors;
#endif

float factorOf(float magnitude, float entry) {
  float row = 0.0, factor = first_factor;
  for (int i = 0; i + 1 < GRADIENT_ROWS; ++i) {
    float passed = clamp((magnitude - gradient_rows[i].x) * gradient_rows[i].y, 0.0, 1.0);
    row += passed;
    factor += passed * gradient_rows[i].z;
  }
#if FACTOR_TABLE
  factor = textureLod(factors, vec2(entry, (row + 0.5) / float(GRADIENT_ROWS)), 0.0).r;
#endif
  return factor;
}

// The opacity of `voxel_lengths` from that of one.
float corrected(float opacity, float voxel_lengths) {
#if CORRECTS
  return opacity < 1.0 ? 1.0 - exp2(voxel_lengths * log2(1.0 - opacity)) : 1.0;
#else
  return opacity;
#endif
}
#endif

#if LIT
uniform float flat_difference;  // `flat`, in texel values
uniform vec4 lights[2];      // toward, strength
uniform vec3 halfways[2];
uniform vec4 reflectance;    // ambient, diffuse, specular, shininess

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
  return pow(x, vec2(reflectance.w));
#endif
}

// `color` premultiplied; g and steepest as of gradientAt().
vec4 shade(vec4 color, vec3 g, float steepest) {
  float flatness = flat_difference / steepest;
  float squared = dot(g, g);
  vec3 normal = g * inversesqrt(squared);
  vec2 strength = vec2(lights[0].w, lights[1].w);
  vec2 facing = abs(vec2(dot(normal, lights[0].xyz), dot(normal, lights[1].xyz)));
  vec2 mirrored = abs(vec2(dot(normal, halfways[0]), dot(normal, halfways[1])));
  float diffuse = dot(strength, facing), specular = dot(strength, shine(mirrored));
  vec3 lit = color.rgb * (reflectance.x + reflectance.y * diffuse) +
             color.a * reflectance.z * specular;
  lit = mix(color.rgb, lit, squared / (squared + flatness * flatness));
  return vec4(steepest > 0.0 ? lit : color.rgb, color.a);
}
#endif

vec3 textureOrder(vec3 v) { return turn == 2 ? v : turn == 0 ? v.yzx : v.zxy; }

void main() {
  vec2 pixel = gl_FragCoord.xy;
  vec3 step = step0 + pixel.x * step_dx + pixel.y * step_dy;
  ivec2 range = slices(pixel.x * origin_dx + pixel.y * origin_dy, step);
  if (range.x >= range.y) discard;
  vec3 along = textureOrder(step) * texel_size;
  vec3 first = texel0 + pixel.x * texel_dx + pixel.y * texel_dy;
#if PERSPECTIVE
  float ray_length = length(vec3(pixel.x * pixel_ray.x + pixel_ray.y, pixel.y * pixel_ray.z + pixel_ray.w, 1.0));
#else
  const float ray_length = 1.0;
#endif
  vec4 sum = MODE == 1 ? vec4(-3e38) : MODE == 2 ? vec4(3e38) : vec4(0.0);
#if WITH_DEPTH
  float weighted_depth = 0.0;
#endif
#if COUNTS_TAKEN
  taken = vec4(0.0);
#endif
  for (int k = range.x; k < range.y; ++k) {
    vec3 at;
    float entry, value;
    vec4 color;
#if GRADIENTS
    // On to the next sample that may show something. Software GL runs a loop's body for several
    // pixels together, as long as any of them needs it, and skips nothing by `if`: so each pixel goes
    // ahead to where it has something to light, and the reads there are made for all at once.
    for (;; ++k) {
#endif
#if COUNTS_TAKEN
      taken.r += 1.0;
#endif
      at = first + float(k - first_k) * along;
      value = textureLod(chunk, at, 0.0).r;
      entry = value * entry_scale + entry_offset;
#if FLOATS
      entry = clamp(entry, 0.0, 1.0);  // drivers may wrap where a coordinate is beyond integers
#endif
      color = textureLod(look_up, vec2(entry, 0.5), 0.0);
#if FLOATS
      if (IS_NO_NUMBER(vec3(value)).x) color = vec4(0.0);
#endif
#if GRADIENTS
      if (color.a != 0.0 || k + 1 == range.y) break;
    }
#endif
#if MODE == 0
#if GRADIENTS
    float steepest;
    vec3 g = gradientAt(at, steepest);
#endif
#if GRADIENT_ROWS > 0
    color.a = corrected(color.a * factorOf(steepest * length(g), entry), slice_length * ray_length);
    color.rgb *= color.a;
#elif PERSPECTIVE
    color.a = 1.0 - exp2(color.a * ray_length);
    color.rgb *= color.a;
#endif
#if LIT
    color = shade(color, g, steepest);
#endif
#if WITH_DEPTH
    weighted_depth += (1.0 - sum.a) * color.a * (first_depth + (float(k) + 0.5) * depth_step);
#endif
    sum += (1.0 - sum.a) * color;
#if STOPS_EARLY
    if (sum.a >= stop_opacity) break;
#endif
#else
    // A sample's part (alpha) moves its value toward the end that loses: to (max, greatest part),
    // (min, 1 - greatest part) or (sum, sum of parts).
    float part = color.a;
#if MODE == 1
    if (part > 0.0) sum.rg = max(sum.rg, vec2(mix(least, value, part), part));
#elif MODE == 2
    if (part > 0.0) sum.rg = min(sum.rg, vec2(mix(greatest, value, part), 1.0 - part));
#else
    if (part > 0.0) sum.rg += vec2(value * part, part);
#endif
#endif
  }
  result = sum;
#if WITH_DEPTH
  depth_sum = vec4(weighted_depth, 0.0, 0.0, sum.a);
#endif
}
)";

}  // namespace

std::string vertexShader() {
  return fmt::format("{}#define FLAT flat out\n{}{}", kVersion, kInputs, kVertex);
}

std::string fragmentShader(const ShaderVariant& v) {
  std::string source = kVersion;
  source += fmt::format("#define MODE {}\n#define PERSPECTIVE {}\n#define LIT {}\n",
                        static_cast<int>(v.mode), int{v.perspective}, int{v.lit});
  source += fmt::format("#define WITH_DEPTH {}\n#define STOPS_EARLY {}\n#define CLIP_PLANES {}\n",
                        int{v.with_depth}, int{v.stops_early}, v.clip_planes);
  source += fmt::format("#define FLOATS {}\n#define COUNTS_TAKEN {}\n", int{v.floats},
                        int{v.counts_taken});
  source += fmt::format("#define GRADIENTS {}\n#define GRADIENT_ROWS {}\n",
                        int{v.lit || v.gradient_rows > 0}, v.gradient_rows);
  source += fmt::format("#define SHININESS {}\n#define FACTOR_TABLE {}\n#define CORRECTS {}\n",
                        v.shininess, int{v.factor_table}, int{v.corrects});
  source += "#define FLAT flat in\n";
  source += kInputs;
  source += kInterval;
  source += v.counts ? kCount : kSample;
  return source;
}

}  // namespace sluice

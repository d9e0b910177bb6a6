#include "src/gl/shaders/shader_text.h"

namespace sluice {

// A block is a hull of its channels' boxes and a box for each channel; one that the block lacks is
// empty. The vertices outline the hull.
const char* const kBlendedVertexText = R"(
flat out int block_at;
void main() {
  block_at = gl_InstanceID * 13 * (CHANNELS + 1);
  readView();
  vec4 corner = texelFetch(boxes, block_at + gl_VertexID);
  gl_Position = vec4(corner.xy, 0.0, corner.z);
}
)";

// Once for each channel, see blendedFragmentShader(): its way through its box, and its samples.
const char* const kChannelText = R"(
ivec2 range;
vec3 first, along;
void enterBox(int at, vec2 pixel, vec3 origin, vec3 step, float jitter) {
  readBox(at);
  range = slices(origin, step);
  along = textureOrder(step * TEXEL_SCALE) * texel_size;
  first = texel0 + pixel.x * texel_dx + pixel.y * texel_dy + jitter * along;
}

// Adds the channel's colour at slice k, premultiplied.
void addSample(int k, float ray_length, inout vec4 total, inout float clear) {
  if (k < range.x || k >= range.y) return;
#if COUNTS_TAKEN
  taken.r += 1.0;
#endif
  vec3 at = first + float(k - first_k) * along;
#if LABELS
  vec2 both = labelAt(at);
  float part = both.g;
#else
  vec2 both = texelAt(at);
  const float part = 1.0;
#endif
  float value = both.r;
#if FLOATS
  if (IS_NO_NUMBER(vec3(value)).x) return;
#endif
#if GOES_AHEAD
  bool shows = value >= visible.x && value <= visible.y;
#if SPREAD
  shows = shows || both.g > 0.0;
#endif
  if (!shows) return;
#endif
#if GRADIENT_ROWS > 0 || LABELS
  float voxel_lengths = slice_length * ray_length;
#else
  const float voxel_lengths = 1.0;
#endif
  float entry = entryOf(value);
  vec4 color = shownColor(entryColor(value, entry), value, part, entry, at, ray_length,
                          voxel_lengths, vec3(0.0));
  total += color;
  clear *= 1.0 - color.a;
}
)";

// ENTER_BOXES and ADD_SAMPLES call enterBox() and addSample() of each channel.
const char* const kBlendedText = R"(
flat in int block_at;
// [from, to) of both.
ivec2 united(ivec2 a, ivec2 b) {
  return a.x >= a.y ? b : b.x >= b.y ? a : ivec2(min(a.x, b.x), max(a.y, b.y));
}
void main() {
  vec2 pixel = gl_FragCoord.xy + vec2(0.0, first_row);
  vec3 ray_step = step0 + pixel.x * step_dx + pixel.y * step_dy;
  float jitter = jitterAt(pixel);
  vec3 origin = pixel.x * origin_dx + pixel.y * origin_dy + jitter * ray_step;
  float ray_length = rayLengthAt(pixel);
  ivec2 all_slices = ivec2(0);
  ENTER_BOXES
  if (all_slices.x >= all_slices.y) discard;
  vec4 sum = vec4(0.0);
#if WITH_DEPTH
  float weighted_depth = 0.0;
#endif
#if COUNTS_TAKEN
  taken = vec4(0.0);
#endif
  for (int k = all_slices.x; k < all_slices.y; ++k) {
    vec4 total = vec4(0.0);
    float clear = 1.0;
    ADD_SAMPLES
    // Opacities multiply as those of media that fill the same space do, and the colours are the
    // mean by opacity.
    vec4 color = vec4(total.rgb * ((1.0 - clear) / max(total.a, 1e-20)), 1.0 - clear);
#if WITH_DEPTH
    weighted_depth += (1.0 - sum.a) * color.a * (first_depth + (float(k) + jitter + 0.5) * depth_step);
#endif
    sum += (1.0 - sum.a) * cued(color, float(k) + jitter);
#if STOPS_EARLY
    if (sum.a >= stop_opacity) break;
#endif
  }
  result = sum;
#if WITH_DEPTH
  depth_sum = vec4(weighted_depth, 0.0, 0.0, sum.a);
#endif
}
)";

}  // namespace sluice

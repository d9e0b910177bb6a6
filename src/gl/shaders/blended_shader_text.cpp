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

// Once for each channel, see blendedFragmentShader(): its samples.
const char* const kChannelText = R"(
// Adds the channel's colour at slice k, premultiplied.
void addSample(int k, Ray ray, inout vec4 total, inout float clear) {
  if (k < range.x || k >= range.y) return;
  countSample();
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
  if (!mayShow(both)) return;
  float entry = entryOf(value);
  vec4 color = shownColor(entryColor(value, entry), value, part, entry, at, ray.length,
                          voxelLengths(ray.length), vec3(0.0));
  total += color;
  clear *= 1.0 - color.a;
}
)";

// ENTER_BOXES and ADD_SAMPLES call readBox(), enterBox() and addSample() of each channel.
const char* const kBlendedText = R"(
flat in int block_at;
// [from, to) of both.
ivec2 united(ivec2 a, ivec2 b) {
  return a.x >= a.y ? b : b.x >= b.y ? a : ivec2(min(a.x, b.x), max(a.y, b.y));
}
void main() {
  vec2 pixel = gl_FragCoord.xy + vec2(0.0, first_row);
  Ray ray = rayAt(pixel);
  ivec2 all_slices = ivec2(0);
  ENTER_BOXES
  if (all_slices.x >= all_slices.y) discard;
  beginSumWith(vec4(0.0));
  for (int k = all_slices.x; k < all_slices.y; ++k) {
    vec4 total = vec4(0.0);
    float clear = 1.0;
    ADD_SAMPLES
    // Opacities multiply as those of media that fill the same space do, and the colours are the
    // mean by opacity.
    vec4 color = vec4(total.rgb * ((1.0 - clear) / max(total.a, 1e-20)), 1.0 - clear);
    blend(color, float(k) + ray.jitter);
    if (isOpaque()) break;
  }
  writeSum();
}
)";

}  // namespace sluice

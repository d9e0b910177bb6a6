#include "src/gl/shaders/shader_text.h"

namespace sluice {

const char* const kSumText = R"(
#if WITH_DEPTH
layout(location = 1) out vec4 depth_sum;  // opacity times depth, and opacity to blend by
float weighted_depth;
#endif
#if COUNTS_TAKEN
layout(location = 1) out vec4 taken;  // samples; of opacity 0, so that they add up
#endif
#if CUES_DEPTH
uniform vec3 depth_cue;  // how much slice -1/2 is darkened, each slice more, and the most
#endif
// The samples so far, combined.
vec4 sum;

void beginSumWith(vec4 nothing) {
  sum = nothing;
#if WITH_DEPTH
  weighted_depth = 0.0;
#endif
#if COUNTS_TAKEN
  taken = vec4(0.0);
#endif
}

void countSample() {
#if COUNTS_TAKEN
  taken.r += 1.0;
#endif
}

// Blends a premultiplied colour at a slice, which may lie between two, under the sum.
void blend(vec4 color, float slice) {
  float clear = 1.0 - sum.a;
#if WITH_DEPTH
  weighted_depth += clear * color.a * (first_depth + (slice + 0.5) * depth_step);
#endif
#if CUES_DEPTH
  color.rgb *= 1.0 - clamp(depth_cue.x + (slice + 0.5) * depth_cue.y, 0.0, depth_cue.z);
#endif
  sum += clear * color;
}

bool isOpaque() {
#if STOPS_EARLY
  return sum.a >= stop_opacity;
#else
  return false;
#endif
}

void writeSum() {
  result = sum;
#if WITH_DEPTH
  depth_sum = vec4(weighted_depth, 0.0, 0.0, sum.a);
#endif
}
)";

const char* const kBlendText = R"(
void beginSum(Ray ray) { beginSumWith(vec4(0.0)); }
void combine(Sample next, int k, Ray ray) { blend(next.color, float(k) + ray.jitter); }
)";

// In the other modes a sample's part (alpha) moves its value towards the end that loses, and the
// greatest part is kept beside it.

const char* const kGreatestText = R"(
void beginSum(Ray ray) { beginSumWith(vec4(-3e38)); }
void combine(Sample next, int k, Ray ray) {
  float part = next.color.a;
  if (part > 0.0) sum.rg = max(sum.rg, vec2(mix(least, next.value, part), part));
}
)";

const char* const kLeastText = R"(
void beginSum(Ray ray) { beginSumWith(vec4(3e38)); }
void combine(Sample next, int k, Ray ray) {
  float part = next.color.a;
  if (part > 0.0) sum.rg = min(sum.rg, vec2(mix(greatest, next.value, part), 1.0 - part));
}
)";

const char* const kAverageText = R"(
void beginSum(Ray ray) { beginSumWith(vec4(0.0)); }
// The values times their parts, and the parts.
void combine(Sample next, int k, Ray ray) {
  float part = next.color.a;
  if (part > 0.0) sum.rg += vec2(next.value * part, part);
}
)";

const char* const kAttenuatedText = R"(
uniform sampler2D kept;  // the target before this box
// FrameSetup::window: its first value, 1 / its length; the attenuation from slice to slice.
uniform vec3 window_texels;
// Read once a pixel: software GL reads uniforms again in every turn of a loop.
vec2 window;
float attenuation;
void beginSum(Ray ray) {
  beginSumWith(texelFetch(kept, ivec2(gl_FragCoord.xy), 0));
  window = window_texels.xy;
  attenuation = window_texels.z * ray.length;
}
// The greatest of the dimmed values, what dims those behind, and the greatest part.
void combine(Sample next, int k, Ray ray) {
  float part = next.color.a;
  float level = part > 0.0 ? clamp((next.value - window.x) * window.y, 0.0, 1.0) * part : 0.0;
  float clear = 1.0 - sum.g;
  sum = vec4(max(sum.r, clear * level), sum.g + clear * (1.0 - exp(-attenuation * level)),
             max(sum.b, part), 0.0);
}
)";

const char* const kDepthCodeText = R"(
// See depth_code.h.
#define PLACE_STEPS 4094.0
#define PLACE_SHIFT 0.618
#define DEPTH_STEPS 4096.0
uniform vec3 window_texels;  // FrameSetup::window: its first value, 1 / its length
uniform vec4 depth_row;      // depthRow() of positions from the rays' common origin
vec2 window;
void beginSum(Ray ray) {
  beginSumWith(vec4(-3e38));
  window = window_texels.xy;
}
// The code of the greatest, and the greatest part.
void combine(Sample next, int k, Ray ray) {
  float part = next.color.a;
  // The hardware's interpolation may be too coarse to tell values from each other: those that may
  // be the greatest are read exactly. A loop, since software GL skips no `if`.
  float level = clamp((next.value - window.x) * window.y, 0.0, 1.0) * part;
  for (bool again = part > 0.0 && level * PLACE_STEPS > sum.r / DEPTH_STEPS - 64.0; again;
       again = false) {
    level = clamp((exactAt(next.at).r - window.x) * window.y, 0.0, 1.0) * part;
    float depth = clamp(dot(depth_row.xyz, box_lo + voxelAt(k)) + depth_row.w, 0.0, 1.0);
    float code = floor(level * PLACE_STEPS + PLACE_SHIFT) * DEPTH_STEPS +
                 floor((1.0 - depth) * (DEPTH_STEPS - 1.0) + 0.5);
    sum.rg = max(sum.rg, vec2(code, part));
  }
}
)";

}  // namespace sluice

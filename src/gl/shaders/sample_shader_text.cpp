#include "src/gl/shaders/shader_text.h"

namespace sluice {

const char* const kSampleText = R"(
#if LIGHT_VOLUME
// These turn an index position, from the rays' common origin, into a place in the light volume.
uniform vec3 light_scale, light_offset;
#endif
// See depth_code.h.
#define PLACE_STEPS 4094.0
#define PLACE_SHIFT 0.618
#define DEPTH_STEPS 4096.0
void main() {
  vec2 pixel = gl_FragCoord.xy + vec2(0.0, first_row);
#if PLANES
  vec3 start, way, size, corner;
  vec2 ends;
  ivec2 range = planes(pixel, start, way, size, corner, ends);
  if (range.x >= range.y) discard;
#else
  vec3 step = step0 + pixel.x * step_dx + pixel.y * step_dy;
  float jitter = jitterAt(pixel);
  vec3 origin = pixel.x * origin_dx + pixel.y * origin_dy + jitter * step;
  ivec2 range = slices(origin, step);
  if (range.x >= range.y) discard;
  vec3 along = textureOrder(step * TEXEL_SCALE) * texel_size;
  vec3 first = texel0 + pixel.x * texel_dx + pixel.y * texel_dy + jitter * along;
#endif
  float ray_length = rayLengthAt(pixel);
#if GRADIENT_ROWS > 0 || LABELS
  float voxel_lengths = slice_length * ray_length;
#else
  const float voxel_lengths = 1.0;
#endif
#if LIGHT_VOLUME
  vec3 light_along = step * light_scale;
  vec3 light_first =
      (pixel.x * origin_dx + pixel.y * origin_dy + 0.5 * step) * light_scale + light_offset;
#define LIGHT_AT(k) (light_first + (jitter + (k)) * light_along)
#else
#define LIGHT_AT(k) vec3(0.0)
#endif
#if SURFACES > 0
  float near_end, far_end = endAt(first + (float(range.x - first_k) - 0.5) * along);
#endif
#if COMBINING == 4
  // Read once: software GL reads uniforms again in every turn of a loop.
  vec4 sum = texelFetch(kept, ivec2(gl_FragCoord.xy), 0);
  vec2 window = window_texels.xy;
  float attenuation = window_texels.z * ray_length;
#else
#if CODES_DEPTH
  vec2 window = window_texels.xy;
#endif
  vec4 sum = COMBINING == 1 ? vec4(-3e38) : COMBINING == 2 ? vec4(3e38) : vec4(0.0);
#endif
#if WITH_DEPTH
  float weighted_depth = 0.0;
#endif
#if COUNTS_TAKEN
  taken = vec4(0.0);
#endif
#if INTEGRATES
  // Segments have the values at both ends, which may lie in the ghost layer.
  float front, back = filteredAt(first + (float(range.x - first_k) - 0.5) * along).r;
#endif
  for (int k = range.x; k < range.y; ++k) {
    vec3 at;
    float value = 0.0;
#if GOES_AHEAD
    // On to the next sample that may show something. Software GL runs a loop's body for several
    // pixels together, as long as any of them needs it, and skips nothing by `if`: so each pixel goes
    // ahead to where it has something to light, and the reads there are made for all at once.
    for (;; ++k) {
#endif
#if COUNTS_TAKEN
      taken.r += 1.0;
#endif
#if PLANES
      float place = clamp(float(k), ends.x, ends.y);
      vec3 voxel = clamp(start + place * way, vec3(0.0), size);
      at = textureOrder(corner + voxel * TEXEL_SCALE) * texel_size;
#else
      at = first + float(k - first_k) * along;
#endif
#if SURFACES > 0
      near_end = far_end;
      far_end = endAt(at + 0.5 * along);
      vec2 both = texelAt(at);
      value = both.r;
      bool shows = value >= visible.x && value <= visible.y;
#if SPREAD
      shows = shows || both.g > 0.0;
#endif
      if (mayMeet(near_end, far_end) || (HAS_OPACITIES == 1 && shows) || k + 1 == range.y) break;
    }
#elif INTEGRATES
      front = back;
      back = filteredAt(at + 0.5 * along).r;
#if GOES_AHEAD
      if ((max(front, back) >= visible.x && min(front, back) <= visible.y) || k + 1 == range.y)
        break;
    }
#endif
#else
#if GOES_AHEAD
      vec2 both = texelAt(at);
      value = both.r;
#if SPREAD
      if (both.g > 0.0) break;
#endif
      bool shows = value >= visible.x && value <= visible.y;
#if LABELS
      // Between labels the hardware's value is none of them. It is 0 where all of them are.
      for (bool again = value != 0.0; again; again = false) {
        float label = labelAt(at).r;
        shows = label >= visible.x && label <= visible.y;
      }
#endif
      if (shows || k + 1 == range.y) break;
    }
#elif PLANES && FLOATS && FETCHES
      value = valueOnPlane(at);
#else
      value = texelAt(at).r;
#endif
#endif
#if INTEGRATES
    float from = front, to = back;
#if FLOATS
    // Next to a voxel that is no number the other end stands for all.
    if (IS_NO_NUMBER(vec3(front)).x) from = back;
    if (IS_NO_NUMBER(vec3(back)).x) to = front;
#endif
    SumsAt sums_before = sumsAt(from), sums_after = sumsAt(to);
    vec4 color = segmentColor(sums_before, sums_after);
#if FLOATS
    if (IS_NO_NUMBER(vec3(from)).x) color = vec4(0.0);
#endif
    float entry = (clamp(0.5 * (sums_before.place + sums_after.place), 0.0, sums_line.x) + 0.5) /
                  (sums_line.x + 1.0);
#else
#if LABELS
    vec2 label = labelAt(at);
    value = label.r;
#elif PLANES && FLOATS && !FETCHES
    // A loop, since software GL skips no `if`.
    for (bool again = IS_NO_NUMBER(vec3(value)).x; again; again = false) value = valueOnPlane(at);
#endif
    float entry = entryOf(value);
    vec4 color = entryColor(value, entry);
#endif
#if SURFACES > 0 && !HAS_OPACITIES
    color = vec4(0.0);
#elif COMBINING == 0
#if LABELS
    float part = label.g;
#else
    const float part = 1.0;
#endif
    color = shownColor(color, value, part, entry, at, ray_length, voxel_lengths,
                       LIGHT_AT(float(k)));
#endif
#if COMBINING == 0
#if SURFACES > 0
    // The slice is blended in parts, with a surface behind each but the last.
    float from = 0.0;
    // A loop, since software GL skips no `if`.
    for (bool again = mayMeet(near_end, far_end); again; again = false) {
      float h = float(k - first_k) - 0.5;
      float front = sharedEndAt(origin, step, float(k), first + h * along);
      float back = sharedEndAt(origin, step, float(k + 1), first + (h + 1.0) * along);
      bool up = back > front;
      float value_from = front;
      for (int n = 0; n < SURFACES; ++n) {
        int i = up ? n : SURFACES - 1 - n;
        float level = surface_levels[i];
        for (bool meets = meetsLevel(front, back, level); meets; meets = false) {
          float part = crossing(first, along, h, level, from, value_from, back, up);
          vec4 before = partOf(color, part - from);
#if WITH_DEPTH
          weighted_depth += (1.0 - sum.a) * before.a * (first_depth + (float(k) + jitter + 0.5) * depth_step);
#endif
          sum += (1.0 - sum.a) * cued(before, float(k) + jitter);
          vec4 surface = surfaceColor(first + (h + part) * along, level, surface_colors[i],
                                      LIGHT_AT(float(k) - 0.5 + part));
#if WITH_DEPTH
          weighted_depth += (1.0 - sum.a) * surface.a * (first_depth + (float(k) + jitter + part) * depth_step);
#endif
          sum += (1.0 - sum.a) * cued(surface, float(k) + jitter - 0.5 + part);
          from = part;
          value_from = level;
        }
      }
    }
    color = partOf(color, 1.0 - from);
#endif
#if WITH_DEPTH
    weighted_depth += (1.0 - sum.a) * color.a * (first_depth + (float(k) + jitter + 0.5) * depth_step);
#endif
    sum += (1.0 - sum.a) * cued(color, float(k) + jitter);
#if STOPS_EARLY
    if (sum.a >= stop_opacity) break;
#endif
#else
    // A sample's part (alpha) moves its value toward the end that loses: to (max, greatest part),
    // (min, 1 - greatest part), (sum, sum of parts), (dimmed max, what dims those behind, greatest
    // part), or, by depth, (code of the greatest, greatest part).
    float part = color.a;
#if CODES_DEPTH
    // The hardware's interpolation may be too coarse to tell values from each other: those that may
    // be the greatest are read exactly. A loop, since software GL skips no `if`.
    float level = clamp((value - window.x) * window.y, 0.0, 1.0) * part;
    for (bool again = part > 0.0 && level * PLACE_STEPS > sum.r / DEPTH_STEPS - 64.0; again;
         again = false) {
      level = clamp((exactAt(at).r - window.x) * window.y, 0.0, 1.0) * part;
      float depth = clamp(dot(depth_row.xyz, box_lo + voxel) + depth_row.w, 0.0, 1.0);
      float code = floor(level * PLACE_STEPS + PLACE_SHIFT) * DEPTH_STEPS +
                   floor((1.0 - depth) * (DEPTH_STEPS - 1.0) + 0.5);
      sum.rg = max(sum.rg, vec2(code, part));
    }
#elif COMBINING == 1
    if (part > 0.0) sum.rg = max(sum.rg, vec2(mix(least, value, part), part));
#elif COMBINING == 2
    if (part > 0.0) sum.rg = min(sum.rg, vec2(mix(greatest, value, part), 1.0 - part));
#elif COMBINING == 4
    float level = part > 0.0 ? clamp((value - window.x) * window.y, 0.0, 1.0) * part : 0.0;
    float clear = 1.0 - sum.g;
    sum = vec4(max(sum.r, clear * level), sum.g + clear * (1.0 - exp(-attenuation * level)),
               max(sum.b, part), 0.0);
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

}  // namespace sluice

#include "src/gl/shaders/shader_text.h"

namespace sluice {

const char* const kSurfaceText = R"(
uniform float surface_levels[SURFACES];  // texel values, ascending
uniform vec4 surface_colors[SURFACES];   // premultiplied
uniform vec3 place_origin;    // of the rays' common origin, from placeBase()

// Whether an exact look at the values of both ends may find a level between them.
bool mayMeet(float front, float back) {
  bool may = false;
  float lo = min(front, back) - filter_tie, hi = max(front, back) + filter_tie;
  for (int i = 0; i < SURFACES; ++i)
    may = may || (surface_levels[i] >= lo && surface_levels[i] <= hi);
#if FLOATS
  may = may && !IS_NO_NUMBER(vec3(min(front, back))).x;
#endif
  return may;
}

// The value where the ray passes from slice turn - 1 to slice `turn`: neighbouring boxes find the
// same at the place that they share, see FrameSetup::has_surfaces.
float sharedEndAt(vec3 origin, vec3 step, float turn) {
  const float kGrid = 8192.0;
  vec3 place = round((place_origin + origin + turn * step) * kGrid) / kGrid;
  vec3 local = textureOrder((place - round(box_lo + place_origin)) * TEXEL_SCALE);
  return exactOf(box_corner - 0.5 + local).r;
}

bool meetsLevel(float front, float back, float level) {
  bool passes = (front >= level) != (back >= level);
#if FLOATS
  if (IS_NO_NUMBER(vec3(min(front, back))).x) passes = false;
#endif
  return passes;
}

// The part of the way from place h on, in slices, at which the values pass the level: halved six
// times, and once more where a straight line between the two last values passes it.
float crossing(vec3 first, vec3 along, float h, float level, float lo, float value_lo,
               float value_hi, bool up) {
  float hi = 1.0;
  for (int i = 0; i < 6; ++i) {
    float middle = 0.5 * (lo + hi);
    float value = exactAt(first + (h + middle) * along).r;
    bool is_before = (value < level) == up;
    lo = is_before ? middle : lo;
    value_lo = is_before ? value : value_lo;
    hi = is_before ? hi : middle;
    value_hi = is_before ? value_hi : value;
  }
  float way = value_hi - value_lo;
  float part = abs(way) < 1e-30 ? 0.0 : clamp((level - value_lo) / way, 0.0, 1.0);
  return lo + part * (hi - lo);
}

// The colour of a slice over a part of its way.
vec4 partOf(vec4 color, float part) {
  float opacity = color.a < 1.0 ? 1.0 - exp2(part * log2(1.0 - color.a)) : part > 0.0 ? 1.0 : 0.0;
  return color * (opacity / max(color.a, 1e-20));
}

#if FADES
uniform float fade_start[6];  // along the texture's axes, and along these again
uniform float fade_slope[6];

// A surface's colour with the box's share of it, see LevelFade.
vec4 fadedAt(vec3 at, vec4 color) {
  vec3 texel = at / texel_size - 0.5;
  float share = 1.0;
  for (int i = 0; i < 6; ++i) share *= clamp(fade_start[i] + fade_slope[i] * texel[i % 3], 0.0, 1.0);
  return color.a < 1.0 ? partOf(color, share) : color;
}
#endif

// The colour of a surface at a place: its normal is the difference between the corners of a cube.
vec4 surfaceColor(vec3 at, float level, vec4 color, vec3 light_at) {
#if FADES
  color = fadedAt(at, color);
#endif
#if LIT
  vec3 difference = vec3(0.0);
  for (int i = 0; i < 8; ++i) {
    vec3 side = vec3((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0,
                     (i & 4) != 0 ? 1.0 : -1.0);
    float value = exactAt(at + 0.5 * side * texel_size).r;
#if FLOATS
    if (IS_NO_NUMBER(vec3(value)).x) value = level;
#endif
    difference += side * (0.25 * (value - level));
  }
  float unit = max(max(abs(difference.x), max(abs(difference.y), abs(difference.z))), 1e-37);
  difference /= unit;
  return shade(color, difference, squareOf(difference), vec2(1.0), 0.0, 0.0, light_at);
#else
  return color;
#endif
}

)";

// Once for a box and for each that joins it, see joinedText(): the surfaces that slice k meets.
const char* const kMetText = R"(
void addMet(int k, Ray ray) {
  float h = float(k - first_k) - 0.5;
  float front = sharedEndAt(ray.origin, ray.step, float(k));
  float back = sharedEndAt(ray.origin, ray.step, float(k + 1));
  bool up = back > front;
  float from = 0.0, value_from = front;
  for (int n = 0; n < SURFACES; ++n) {
    int i = up ? n : SURFACES - 1 - n;
    float level = surface_levels[i];
    // A loop, since software GL skips no `if`.
    for (bool meets = meetsLevel(front, back, level); meets; meets = false) {
      from = crossing(first, along, h, level, from, value_from, back, up);
      met_part[met_count] = from;
      met_color[met_count++] = surfaceColor(first + (h + from) * along, level, surface_colors[i],
                                            lightAt(ray, float(k) - 0.5 + from));
      value_from = level;
    }
  }
}
)";

const char* const kJoinedText = R"(
bool mayMeetIn(int k) {
  vec3 at = first + float(k - first_k) * along;
  return k >= range.x && k < range.y && mayMeet(endAt(at - 0.5 * along), endAt(at + 0.5 * along));
}
)";

const char* const kSurfacesText = R"(
// The values at the ends of a slice's way, as endAt() has them.
float near_end, far_end;

void enterSamples() { far_end = endAt(placeAt(range.x) - 0.5 * along); }

// Goes on to the next slice that may meet a surface or show something else.
Sample nextSample(inout int k, Ray ray) {
  vec3 at;
  vec2 both;
  for (;; ++k) {
    countSample();
    at = placeAt(k);
    near_end = far_end;
    far_end = endAt(at + 0.5 * along);
    both = texelAt(at);
    if (mayMeet(near_end, far_end) || (HAS_OPACITIES == 1 && mayShow(both)) || k + 1 == range.y)
      break;
#if JOINED > 0
    if (MAY_MEET_JOINED) break;
#endif
  }
#if HAS_OPACITIES
  return sampleAt(at, both, k, ray);
#else
  return Sample(at, both.r, vec4(0.0));
#endif
}

void beginSum(Ray ray) { beginSumWith(vec4(0.0)); }

#if JOINED > 0
// The slice is blended in parts, with a surface behind each but the last: those of this box and of
// the boxes that join it, in the order in which the ray meets them.
void combine(Sample next, int k, Ray ray) {
  float slice = float(k) + ray.jitter, from = 0.0;
  met_count = 0;
  for (bool again = mayMeet(near_end, far_end); again; again = false) addMet(k, ray);
  ADD_JOINED
  for (int i = 1; i < met_count; ++i)
    for (int j = i; j > 0 && met_part[j] < met_part[j - 1]; --j) {
      float part = met_part[j];
      vec4 color = met_color[j];
      met_part[j] = met_part[j - 1];
      met_color[j] = met_color[j - 1];
      met_part[j - 1] = part;
      met_color[j - 1] = color;
    }
  for (int i = 0; i < met_count; ++i) {
    blend(partOf(next.color, met_part[i] - from), slice);
    blend(met_color[i], slice - 0.5 + met_part[i]);
    from = met_part[i];
  }
  blend(partOf(next.color, 1.0 - from), slice);
}
#else
// The slice is blended in parts, with a surface behind each but the last.
void combine(Sample next, int k, Ray ray) {
  float slice = float(k) + ray.jitter, from = 0.0;
  // A loop, since software GL skips no `if`.
  for (bool again = mayMeet(near_end, far_end); again; again = false) {
    float h = float(k - first_k) - 0.5;
    float front = sharedEndAt(ray.origin, ray.step, float(k));
    float back = sharedEndAt(ray.origin, ray.step, float(k + 1));
    bool up = back > front;
    float value_from = front;
    for (int n = 0; n < SURFACES; ++n) {
      int i = up ? n : SURFACES - 1 - n;
      float level = surface_levels[i];
      for (bool meets = meetsLevel(front, back, level); meets; meets = false) {
        float part = crossing(first, along, h, level, from, value_from, back, up);
        blend(partOf(next.color, part - from), slice);
        blend(surfaceColor(first + (h + part) * along, level, surface_colors[i],
                           lightAt(ray, float(k) - 0.5 + part)),
              slice - 0.5 + part);
        from = part;
        value_from = level;
      }
    }
  }
  blend(partOf(next.color, 1.0 - from), slice);
}
#endif
)";

}  // namespace sluice

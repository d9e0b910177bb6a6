#include "src/gl/shaders/shader_text.h"

namespace sluice {

const char* const kTexelText = R"(
// Texels below are, or are interpolated with, one that stands for NaN.
#define IS_NO_NUMBER(v) lessThan(v, vec3(-2e30))
uniform sampler3D chunk;

// The eight texels around a place, in texels from the first one's centre.
struct Corners {
  ivec3 first, next;
  vec3 part;  // of the way from the first to the next
};
Corners cornersOf(vec3 texel) {
  ivec3 last = textureSize(chunk, 0) - 1;
  vec3 low = floor(texel);
  return Corners(clamp(ivec3(low), ivec3(0), last), clamp(ivec3(low) + 1, ivec3(0), last),
                 texel - low);
}
Corners cornersAt(vec3 at) { return cornersOf(at / texel_size - 0.5); }
bvec3 isNext(int corner) { return bvec3((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0); }
vec2 texelOf(Corners c, int corner) {
  bvec3 next = isNext(corner);
  return texelFetch(chunk, ivec3(next.x ? c.next.x : c.first.x, next.y ? c.next.y : c.first.y,
                                 next.z ? c.next.z : c.first.z), 0).rg;
}
float weightOf(Corners c, int corner) {
  vec3 w = mix(1.0 - c.part, c.part, isNext(corner));
  return w.x * w.y * w.z;
}

// The two numbers of a texel, interpolated from the eight around it.
vec2 exactOf(vec3 texel) {
  Corners c = cornersOf(texel);
  vec4 lower = vec4(texelOf(c, 0), texelOf(c, 1)) * (1.0 - c.part.z) +
               vec4(texelOf(c, 4), texelOf(c, 5)) * c.part.z;
  vec4 upper = vec4(texelOf(c, 2), texelOf(c, 3)) * (1.0 - c.part.z) +
               vec4(texelOf(c, 6), texelOf(c, 7)) * c.part.z;
  vec4 row = lower * (1.0 - c.part.y) + upper * c.part.y;
  return row.xy * (1.0 - c.part.x) + row.zw * c.part.x;
}
vec2 exactAt(vec3 at) { return exactOf(at / texel_size - 0.5); }

// The same from the hardware, which may move a value by `filter_tie`.
uniform float filter_tie;
vec2 roughAt(vec3 at) { return textureLod(chunk, at, 0.0).rg; }

vec2 filteredAt(vec3 at) {
#if FETCHES
  return exactAt(at);
#else
  return roughAt(at);
#endif
}

#if SURFACES > 0
// The value at an end of a slice's way, for finding slices that may meet a surface. Beside values
// that stand for infinities the hardware's are off by more than `filter_tie`.
float endAt(vec3 at) {
#if FLOATS
  return filteredAt(at).r;
#else
  return roughAt(at).r;
#endif
}
#endif

#if PLANES && FLOATS
// On a voxel plane the voxels beside it have no part, but rounding gives them one, and of a texel
// that stands for NaN the least is too much: here it is none.
float valueOnPlane(vec3 at) {
  const float kRounding = 1e-4;
  vec3 texel = at / texel_size - 0.5;
  vec3 nearest = round(texel);
  return exactOf(mix(texel, nearest, lessThan(abs(texel - nearest), vec3(kRounding)))).r;
}
#endif

// The same for a sample: only about that if it shows nothing, or of labels, which labelAt() reads.
vec2 texelAt(vec3 at) {
#if LABELS
  return roughAt(at);
#elif ROUGH_FIRST
  vec2 rough = roughAt(at);
  if (rough.r >= visible.x - filter_tie && rough.r <= visible.y + filter_tie) return exactAt(at);
  return rough;
#elif PLANES && FLOATS && FETCHES
  return vec2(valueOnPlane(at), 0.0);
#else
  return filteredAt(at);
#endif
}

// Whether a texel, or one of the values from one to another, may show. All may unless GOES_AHEAD.
// Software GL runs a loop's body for several pixels together, as long as any of them needs it, and
// skips nothing by `if`: so each pixel goes ahead to where it has something to light, and the reads
// there are made for all at once.
bool mayShow(vec2 both) {
#if GOES_AHEAD && SPREAD
  return both.g > 0.0 || (both.r >= visible.x && both.r <= visible.y);
#elif GOES_AHEAD
  return both.r >= visible.x && both.r <= visible.y;
#else
  return true;
#endif
}
bool mayShowBetween(float front, float back) {
#if GOES_AHEAD
  return max(front, back) >= visible.x && min(front, back) <= visible.y;
#else
  return true;
#endif
}

#if GRADIENTS
#if FETCHES
// The values at a texel before and behind a place along an axis. Along the others there are four
// rows of texels, in the order of `part`'s components; of each, the texels around both values.
vec2 neighbors(vec4 first, vec4 second, vec4 third, vec4 fourth, float along, vec2 part) {
  vec4 before = first * (1.0 - along) + second * along;
  vec4 after = third * (1.0 - along) + fourth * along;
  vec2 weights[2] = vec2[2](vec2(1.0 - part.x, part.x), vec2(1.0 - part.y, part.y));
  vec4 weight = weights[0].xyxy * weights[1].xxyy;
  return vec2(dot(before, weight), dot(after, weight));
}
#endif
// The change from one voxel to the next, along the texture's axes. On software GL the reads beyond
// the first are half of a lit frame, so that gradients kept with the voxels could save that at
// most; they would need 16 bits a component and take eight times the bytes of 8-bit data at every
// level.
vec3 differenceAt(vec3 at) {
#if FETCHES
  ivec3 last = textureSize(chunk, 0) - 1;
  vec3 texel = at / texel_size - 0.5;
  vec3 low = floor(texel), part = texel - low;
  ivec3 i[4];
  for (int n = 0; n < 4; ++n) i[n] = clamp(ivec3(low) + (n - 1), ivec3(0), last);
#define VALUE(a, b, c) texelFetch(chunk, ivec3(i[a].x, i[b].y, i[c].z), 0).r
#define ROWS_X(n) vec4(VALUE(n, 1, 1), VALUE(n, 2, 1), VALUE(n, 1, 2), VALUE(n, 2, 2))
#define ROWS_Y(n) vec4(VALUE(1, n, 1), VALUE(2, n, 1), VALUE(1, n, 2), VALUE(2, n, 2))
#define ROWS_Z(n) vec4(VALUE(1, 1, n), VALUE(2, 1, n), VALUE(1, 2, n), VALUE(2, 2, n))
  vec4 lower = ROWS_Z(1), upper = ROWS_Z(2);  // the eight texels around the place
  vec2 x = neighbors(ROWS_X(0), vec4(lower.xz, upper.xz), vec4(lower.yw, upper.yw), ROWS_X(3),
                     part.x, part.yz);
  vec2 y = neighbors(ROWS_Y(0), vec4(lower.xy, upper.xy), vec4(lower.zw, upper.zw), ROWS_Y(3),
                     part.y, part.xz);
  vec2 z = neighbors(ROWS_Z(0), lower, upper, ROWS_Z(3), part.z, part.xy);
#undef VALUE
#undef ROWS_X
#undef ROWS_Y
#undef ROWS_Z
  vec3 before = vec3(x.x, y.x, z.x), after = vec3(x.y, y.y, z.y);
#else
  vec2 n = vec2(1.0, 0.0);
  vec3 after = vec3(roughAt(at + n.xyy * texel_size).r, roughAt(at + n.yxy * texel_size).r,
                    roughAt(at + n.yyx * texel_size).r);
  vec3 before = vec3(roughAt(at - n.xyy * texel_size).r, roughAt(at - n.yxy * texel_size).r,
                     roughAt(at - n.yyx * texel_size).r);
#endif
  vec3 difference = 0.5 * (after - before);
#if FLOATS
  // A neighbour that is no number says nothing of the slope along its axis.
  difference = mix(difference, vec3(0.0), IS_NO_NUMBER(min(after, before)));
#endif
  return difference;
}
#endif

#if (LABELS && LIT) || (SPREAD && GRADIENTS)
vec2 storedAt(ivec3 texel) {
  return texelFetch(chunk, clamp(texel, ivec3(0), textureSize(chunk, 0) - 1), 0).rg;
}
// Sobel's weights of four texels along an axis, for the slope along it and a mean across it.
vec4 slopeWeights(float part) { return 0.5 * vec4(part - 1.0, -part, 1.0 - part, part); }
vec4 meanWeights(float part) {
  return 0.25 * vec4(1.0 - part, 2.0 - part, 1.0 + part, part);
}
#endif

#if SPREAD
uniform vec4 expected_line;  // of a mean: scale, offset; of a spread: scale, rows
// The spread at a place, as its share of the volume's values; see ExpectedLook for its squares. The
// hardware interpolates what it reads, so the texels are read one by one.
float spreadShareAt(vec3 at) {
  Corners c = cornersAt(at);
  float square = 0.0;
  for (int i = 0; i < 8; ++i) {
    float share = max(texelOf(c, i).g, 0.0) * expected_line.z;
    square += weightOf(c, i) * share * share;
  }
  return sqrt(square);
}
#endif

#if SPREAD && GRADIENTS
// Numbers of rough_light.h: kEvenPart, kOwnPart and kEdgePart; kEdgeVoxels, and scale and offset of `sharp`;
// kLeastPart, kLeastProduct, kLeastHeight, kLeastLayer.
uniform vec3 here_parts;
uniform vec3 edge_parts;
uniform vec4 least_parts;
float texelLength() { return pow(TEXEL_SCALE.x * TEXEL_SCALE.y * TEXEL_SCALE.z, -1.0 / 3.0); }
// The least and the greatest of four texels around a place between the second and the third: the
// farther one of the outer two becomes its neighbour.
float leastOf(vec4 four, float part) {
  vec2 away = clamp(vec2(2.0 * part - 1.0, 1.0 - 2.0 * part), 0.0, 1.0);
  vec2 outer = mix(four.xw, four.yz, away);
  return min(min(outer.x, outer.y), min(four.y, four.z));
}
float greatestOf(vec4 four, float part) { return -leastOf(-four, part); }

// See rough_light.h: the change from one texel to the next along the texture's axes, what counts of
// its square, and the share of that whose light is seen; what counts of the spread, as
// spreadShareAt() returns it, and of the least spread.
struct WideSlopes {
  vec3 slopes;
  float here, seen, spread, noise;
};
WideSlopes wideSlopes(vec3 at, float spread) {
  // Values count from the first texel on, in shares of the volume's. Beyond `far` lie those that
  // stand for infinities.
  const float far = 1e15;
  vec3 texel = at / texel_size - 0.5;
  vec3 low = floor(texel), part = texel - low;
  ivec3 cell = ivec3(low) - 1;
  float first = storedAt(cell + 1).r, least = first;
  vec4 slope_x = slopeWeights(part.x), slope_y = slopeWeights(part.y);
  vec4 mean_x = meanWeights(part.x), mean_y = meanWeights(part.y), mean_z = meanWeights(part.z);
  vec4 planes_x, planes_y, planes_z, planes_squares, planes_least, planes_greatest, planes_calm;
  for (int k = 0; k < 4; ++k) {
    vec4 slopes, means, squares, lows, highs, calms;
    for (int j = 0; j < 4; ++j) {
      vec4 values, spreads;
      for (int i = 0; i < 4; ++i) {
        vec2 both = storedAt(cell + ivec3(i, j, k));
        values[i] = both.r;
        spreads[i] = max(both.g, 0.0);
      }
      least = min(least, min(min(values.x, values.y), min(values.z, values.w)));
      values = clamp((values - first) * expected_line.z, -far, far);
      spreads *= expected_line.z;
      slopes[j] = dot(values, slope_x);
      means[j] = dot(values, mean_x);
      squares[j] = dot(values * values + 0.25 * spreads * spreads, mean_x);
      lows[j] = leastOf(values, part.x);
      highs[j] = greatestOf(values, part.x);
      calms[j] = leastOf(spreads, part.x);
    }
    planes_x[k] = dot(slopes, mean_y);
    planes_y[k] = dot(means, slope_y);
    planes_z[k] = dot(means, mean_y);
    planes_squares[k] = dot(squares, mean_y);
    planes_least[k] = leastOf(lows, part.y);
    planes_greatest[k] = greatestOf(highs, part.y);
    planes_calm[k] = leastOf(calms, part.y);
  }
#if FLOATS
  if (IS_NO_NUMBER(vec3(least)).x) return WideSlopes(differenceAt(at), 1.0, 1.0, spread, 0.0);
#endif
  vec3 slopes =
      vec3(dot(planes_x, mean_z), dot(planes_y, mean_z), dot(planes_z, slopeWeights(part.z)));
  float mean = dot(planes_z, mean_z);
  float variance = max(dot(planes_squares, mean_z) - mean * mean, 0.0);
  float even = dot(slopes, slopes);

  float bottom = leastOf(planes_least, part.z);
  float height = max(greatestOf(planes_greatest, part.z) - bottom, least_parts.z);
  float full = clamp((mean - bottom) / height, least_parts.x, 1.0);
  float of_edge = variance / (height * height * max(full * (1.0 - full), least_parts.y));
  float sharp = clamp(of_edge * edge_parts.y + edge_parts.z, 0.0, 1.0);
  float layer = edge_parts.x / texelLength() * sqrt(even) / height;
  float narrow = max(mix(1.0, min(1.0, layer), sharp), least_parts.w);
  float seen = mix(1.0, min(1.0, 0.5 * layer / full), sharp);

  float own = dot(here_parts.xy, vec2(even, spread * spread));
  float share = min(1.0, own / max(variance, 1e-12));
  float here = mix(share * share * share, 1.0, sharp);
  float counted = min(spread * spread, max(4.0 * variance - here_parts.z * even, 0.0));
  float calm = leastOf(planes_calm, part.z);
  float noise = max(min(calm * calm, counted) - even / SLOPE_PARTS, 0.0);
  return WideSlopes(slopes / max(expected_line.z, 1e-37), here / (narrow * narrow), seen,
                    sqrt(counted), sqrt(noise));
}
#endif
)";

}  // namespace sluice

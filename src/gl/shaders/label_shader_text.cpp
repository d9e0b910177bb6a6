#include "src/gl/shaders/shader_text.h"

namespace sluice {

const char* const kLabelText = R"(
#if LABELS
#if SHARES
uniform float share_unit;    // 1 / the second number of a texel none of which has the label
#endif
// The opacity of a unit length of a texel's label; and, if chunks have shares, the label's share.
vec2 shownOf(vec2 both) {
#if SHARES
  float share = 1.0 - clamp(both.g * share_unit, 0.0, 1.0);
#else
  const float share = 1.0;
#endif
  return vec2(entryColor(both.r, entryOf(both.r)).a, share);
}
// The measure of a body that a label is, 0 to 1, from the greatest share of it around.
float bodyOf(float fullest) { return clamp(4.0 * fullest - 2.0, 0.0, 1.0); }
// The label of a sample, see LookUp; and, if chunks have shares, the part that shows of a whole
// voxel's opacity, see label_shares.h.
vec2 labelAt(vec3 at) {
  const float kTie = 1e-3;
  Corners c = cornersAt(at);
  float values[8];
  float weights[8];
  float share = 0.0, left = 0.0, fullest = 0.0;
  for (int i = 0; i < 8; ++i) {
    vec2 both = texelOf(c, i);
    values[i] = both.r;
    weights[i] = weightOf(c, i);
#if SHARES
    vec2 shown = shownOf(both);
    if (shown.x > 0.0) {
      share += weights[i] * shown.y;
      fullest = max(fullest, shown.y);
    } else {
      left += weights[i] * (1.0 - shown.y);
      weights[i] = -2.0;  // below what any label that shows has together: those win
    }
#endif
  }
  float best = values[0], most = -1.0;
  for (int i = 0; i < 8; ++i) {
    float weight = 0.0;
    for (int k = 0; k < 8; ++k) weight += values[k] == values[i] ? weights[k] : 0.0;
    if (weight > most + kTie || (weight > most - kTie && values[i] > best)) {
      best = values[i];
      most = weight;
    }
  }
  float body = bodyOf(fullest);
  share += body * left;
  return vec2(best, mix(share, clamp(2.0 * share - 0.5, 0.0, 1.0), body));
}
#endif

#if SHARES
// The opacity of a sample of a label of which a part shows, see label_shares.h.
float sharedOpacity(float opacity, float part, float lengths) {
  float texel_length = pow(TEXEL_SCALE.x * TEXEL_SCALE.y * TEXEL_SCALE.z, -1.0 / 3.0);
  float whole = corrected(opacity, texel_length);
  return corrected(whole * part, lengths / texel_length);
}
#endif

#if LABELS && LIT
// The opacity of the one label that shows in the 4 x 4 x 4 texels around a cell, and how much of a
// body it is; 0: none does, or several do, or chunks have no shares.
vec2 soleBody(ivec3 cell) {
  float opacity = 0.0, fullest = 0.0;
#if SHARES
  float least = 3e38, greatest = -3e38;
  for (int i = 0; i < 64; ++i) {
    vec2 both = storedAt(cell + ivec3(i % 4, i / 4 % 4, i / 16) - 1);
    vec2 shown = shownOf(both);
    if (shown.x > 0.0) {
      least = min(least, both.r);
      greatest = max(greatest, both.r);
      opacity = shown.x;
      fullest = max(fullest, shown.y);
    }
  }
  if (least < greatest) opacity = 0.0;
#endif
  return vec2(opacity, bodyOf(fullest));
}
float opacityAt(ivec3 texel, vec2 sole) {
  vec2 shown = shownOf(storedAt(texel));
  if (!(sole.x > 0.0)) return shown.x;
  return sole.x * (shown.x > 0.0 ? shown.y : sole.y * (1.0 - shown.y));
}
// The slopes that light labels, from texel to texel, by Sobel's operator at the eight texels around
// a place, interpolated: see lighting.h and label_shares.h.
vec3 labelSlopes(vec3 at) {
  vec3 texel = at / texel_size - 0.5;
  vec3 low = floor(texel), part = texel - low;
  vec4 slope_x = slopeWeights(part.x), slope_y = slopeWeights(part.y);
  vec4 mean_x = meanWeights(part.x), mean_y = meanWeights(part.y);
  vec4 planes_x, planes_y, planes_z;
  vec2 sole = soleBody(ivec3(low));
  for (int k = 0; k < 4; ++k) {
    vec4 slopes, means;
    for (int j = 0; j < 4; ++j) {
      ivec3 row = ivec3(low) + ivec3(-1, j - 1, k - 1);
      vec4 opacity =
          vec4(opacityAt(row, sole), opacityAt(row + ivec3(1, 0, 0), sole),
               opacityAt(row + ivec3(2, 0, 0), sole), opacityAt(row + ivec3(3, 0, 0), sole));
      slopes[j] = dot(opacity, slope_x);
      means[j] = dot(opacity, mean_x);
    }
    planes_x[k] = dot(slopes, mean_y);
    planes_y[k] = dot(means, slope_y);
    planes_z[k] = dot(means, mean_y);
  }
  vec4 mean_z = meanWeights(part.z);
  return vec3(dot(planes_x, mean_z), dot(planes_y, mean_z), dot(planes_z, slopeWeights(part.z)));
}
#endif
)";

}  // namespace sluice

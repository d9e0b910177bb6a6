#include "src/gl/shaders/shader_text.h"

namespace sluice {

const char* const kSliceSamplesText = R"(
vec3 placeAt(int k) { return first + float(k - first_k) * along; }

void enter(vec2 pixel, Ray ray) {
  enterBox(pixel, ray);
  if (range.x >= range.y) discard;
}
)";

const char* const kPlaneSamplesText = R"(
ivec2 range;
vec3 start, way, size, corner;
vec2 ends;

void enter(vec2 pixel, Ray ray) {
  range = planes(pixel, start, way, size, corner, ends);
  if (range.x >= range.y) discard;
}

// The place of sample k, in voxels from the box's lower corner.
vec3 voxelAt(int k) {
  return clamp(start + clamp(float(k), ends.x, ends.y) * way, vec3(0.0), size);
}

vec3 placeAt(int k) { return textureOrder(corner + voxelAt(k) * TEXEL_SCALE) * texel_size; }
)";

const char* const kLightPlaceText = R"(
#if LIGHT_VOLUME
uniform sampler3D light;  // LightVolume
uniform float key_share;
// These turn an index position, from the rays' common origin, into a place in the light volume.
uniform vec3 light_scale, light_offset;
vec3 light_first, light_along;
void enterLight(vec2 pixel, Ray ray) {
  light_along = ray.step * light_scale;
  light_first =
      (pixel.x * origin_dx + pixel.y * origin_dy + 0.5 * ray.step) * light_scale + light_offset;
}
vec3 lightAt(Ray ray, float slice) { return light_first + (ray.jitter + slice) * light_along; }
#else
void enterLight(vec2 pixel, Ray ray) {}
vec3 lightAt(Ray ray, float slice) { return vec3(0.0); }
#endif
)";

const char* const kSampleText = R"(
struct Sample {
  vec3 at;  // in the texture
  float value;
  vec4 color;  // of what lies between this sample's slice and the next, premultiplied
};

// The sample at a place whose two numbers are `both`.
Sample sampleAt(vec3 at, vec2 both, int k, Ray ray) {
  float part = 1.0;
#if LABELS
  both = labelAt(at);
  part = both.g;
#elif PLANES && FLOATS && !FETCHES
  // A loop, since software GL skips no `if`.
  for (bool again = IS_NO_NUMBER(vec3(both.r)).x; again; again = false) both.r = valueOnPlane(at);
#endif
  float entry = entryOf(both.r);
  vec4 color = entryColor(both.r, entry);
#if COMBINING == 0
  color = shownColor(color, both.r, part, entry, at, ray.length, voxelLengths(ray.length),
                     lightAt(ray, float(k)));
#endif
  return Sample(at, both.r, color);
}
)";

const char* const kValuesText = R"(
void enterSamples() {}

Sample nextSample(inout int k, Ray ray) {
  vec3 at;
  vec2 both;
  for (;; ++k) {
    countSample();
    at = placeAt(k);
    both = texelAt(at);
#if LABELS && GOES_AHEAD
    // Between labels the hardware's value is none of them. It is 0 where all of them are.
    for (bool again = both.r != 0.0; again; again = false) both = labelAt(at);
#endif
    if (mayShow(both) || k + 1 == range.y) break;
  }
  return sampleAt(at, both, k, ray);
}
)";

const char* const kSegmentsText = R"(
// The values at the ends of the last segment, which may lie in the ghost layer.
float front, back;

void enterSamples() { back = filteredAt(placeAt(range.x) - 0.5 * along).r; }

// The segment around a slice.
Sample nextSample(inout int k, Ray ray) {
  vec3 at;
  for (;; ++k) {
    countSample();
    at = placeAt(k);
    front = back;
    back = filteredAt(at + 0.5 * along).r;
    if (mayShowBetween(front, back) || k + 1 == range.y) break;
  }
  float from = front, to = back;
#if FLOATS
  // Next to a voxel that is no number the other end stands for all.
  if (IS_NO_NUMBER(vec3(front)).x) from = back;
  if (IS_NO_NUMBER(vec3(back)).x) to = front;
#endif
  SumsAt before = sumsAt(from), after = sumsAt(to);
  vec4 color = segmentColor(before, after);
#if FLOATS
  if (IS_NO_NUMBER(vec3(from)).x) color = vec4(0.0);
#endif
  float entry =
      (clamp(0.5 * (before.place + after.place), 0.0, sums_line.x) + 0.5) / (sums_line.x + 1.0);
  color = shownColor(color, 0.0, 1.0, entry, at, ray.length, voxelLengths(ray.length),
                     lightAt(ray, float(k)));
  return Sample(at, 0.0, color);
}
)";

const char* const kSampleMainText = R"(
void main() {
  vec2 pixel = gl_FragCoord.xy + vec2(0.0, first_row);
  Ray ray = rayAt(pixel);
  enter(pixel, ray);
#if JOINED > 0
  ENTER_JOINED
#endif
  enterLight(pixel, ray);
  enterSamples();
  beginSum(ray);
  for (int k = range.x; k < range.y; ++k) {
    Sample next = nextSample(k, ray);
    combine(next, k, ray);
    if (isOpaque()) break;
  }
  writeSum();
}
)";

}  // namespace sluice

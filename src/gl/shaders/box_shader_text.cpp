#include "src/gl/shaders/shader_text.h"

namespace sluice {

// It lies at the nearest depth, so that it hides what the target holds.
const char* const kCoverText = R"(#version 330 core
void main() {
  gl_Position = vec4(4.0 * float(gl_VertexID & 1) - 1.0, 2.0 * float(gl_VertexID & 2) - 1.0, -1.0, 1.0);
}
)";

// The inputs of a fragment: values of the view and of the box. They come as flat inputs, because
// software GL reads a uniform again for each pixel in every turn of a loop, but a flat input once
// for all the pixels that it draws together. GL 3.3 lets 60 components pass; inputs that a variant
// does not read do not count. If all are taken, values read once a pixel stay uniforms.
const char* const kViewInputsText = R"(
uniform samplerBuffer boxes;
uniform float first_row;  // of the picture, the lowest that the target has
FLAT vec3 origin_dx, origin_dy, step0;
FLAT float first_slice;
FLAT float first_depth, depth_step;
FLAT float stop_opacity;
#if PERSPECTIVE && GRADIENTS
uniform vec3 view_step_dx, view_step_dy;
uniform vec4 view_pixel_ray;
#define step_dx view_step_dx
#define step_dy view_step_dy
#define pixel_ray view_pixel_ray
#else
FLAT vec3 step_dx, step_dy;
FLAT vec4 pixel_ray;          // u tan x = x * .x + .y, v tan y = y * .z + .w
#endif
)";

const char* const kBoxInputsText = R"(
// Texels a voxel, along the volume's axes. A program of its own draws boxes of other scales than 1.
#if SCALED
uniform vec3 texel_scale;
#define TEXEL_SCALE texel_scale
#else
#define TEXEL_SCALE vec3(1.0)
#endif
FLAT vec3 box_lo, box_hi;
FLAT vec3 texel0, texel_dx, texel_dy;  // of the texture, 0 to 1; with PLANES in texels
FLAT int first_k, turn;
#if PLANES
FLAT int outer_faces;         // see BoxBuffer
#endif
#if PLANES || SURFACES > 0
FLAT vec3 box_corner;         // of the box, in texels
#endif
FLAT vec3 texel_size;         // 1 / texels of the chunk
FLAT float entry_scale, entry_offset;
FLAT float least, greatest;   // texel values of the first and the last entry
#if KNOWS_VISIBLE
FLAT vec2 visible;            // texel values beyond these show nothing
#endif
#if GRADIENTS
// Along the texture's axes, for a difference of texel values from voxel to voxel: times slope, the
// gradient in the world; the others make products with the direction of the light (times what of it
// is reflected) and with the one in which it would be seen in a mirror.
FLAT vec3 slope;
#endif
#if LIT
FLAT vec3 toward0, toward1, halfway0, halfway1;
FLAT vec4 reflection;         // of what is seen in a mirror, of each light; ambient; flat
#endif
#if GRADIENT_ROWS > 0
FLAT vec4 ramp;               // of the first two rows: magnitude, 1 / distance, factor, its growth
#endif
vec3 textureOrder(vec3 v) { return turn == 2 ? v : turn == 0 ? v.yzx : v.zxy; }
)";

const char* const kReadViewText = R"(
uniform vec3 view_origin_dx, view_origin_dy, view_step0;
uniform float view_first_slice, view_first_depth, view_depth_step;
#if !(PERSPECTIVE && GRADIENTS)
uniform vec3 view_step_dx, view_step_dy;
uniform vec4 view_pixel_ray;
#endif
uniform float opacity_threshold;
void readView() {
  origin_dx = view_origin_dx;
  origin_dy = view_origin_dy;
  step0 = view_step0;
  first_slice = view_first_slice;
  first_depth = view_first_depth;
  depth_step = view_depth_step;
  stop_opacity = opacity_threshold;
#if !(PERSPECTIVE && GRADIENTS)
  step_dx = view_step_dx;
  step_dy = view_step_dy;
  pixel_ray = view_pixel_ray;
#endif
}
)";

const char* const kReadBoxText = R"(
uniform vec3 chunk_texel_size;
uniform vec4 entries;      // scale, offset, least, greatest
#if KNOWS_VISIBLE
uniform vec2 visible_texels;
#endif
#if GRADIENTS
// Along the volume's axes.
uniform vec3 index_slope, index_toward[2], index_halfway[2];
uniform vec4 view_reflection, first_rows;
#endif
// The box whose texels begin at `at`.
void readBox(int at) {
  vec4 lo = texelFetch(boxes, at + 8), hi = texelFetch(boxes, at + 9);
  box_lo = lo.xyz;
  box_hi = hi.xyz;
  first_k = int(lo.w);
  turn = int(hi.w);
  texel_size = chunk_texel_size;
  vec3 texel_unit = PLANES == 1 ? vec3(1.0) : texel_size;
  vec4 texel_ray = texelFetch(boxes, at + 10), ray_dx = texelFetch(boxes, at + 11),
       ray_dy = texelFetch(boxes, at + 12);
  texel0 = texel_ray.xyz * texel_unit;
#if PLANES
  outer_faces = int(texelFetch(boxes, at).w);
#endif
#if PLANES || SURFACES > 0
  box_corner = vec3(texel_ray.w, ray_dx.w, ray_dy.w);
#endif
  texel_dx = ray_dx.xyz * texel_unit;
  texel_dy = ray_dy.xyz * texel_unit;
#if KNOWS_VISIBLE
  visible = visible_texels;
#endif
#if GRADIENTS
  slope = textureOrder(index_slope * TEXEL_SCALE);
#endif
#if LIT
  toward0 = textureOrder(index_toward[0] * TEXEL_SCALE);
  toward1 = textureOrder(index_toward[1] * TEXEL_SCALE);
  halfway0 = textureOrder(index_halfway[0] * TEXEL_SCALE);
  halfway1 = textureOrder(index_halfway[1] * TEXEL_SCALE);
  reflection = view_reflection;
#endif
#if GRADIENT_ROWS > 0
  ramp = first_rows;
#endif
  entry_scale = entries.x;
  entry_offset = entries.y;
  least = entries.z;
  greatest = entries.w;
}
)";

const char* const kVertexText = R"(
void main() {
  // A box that others join is drawn alone.
  int at = gl_InstanceID * 13;
  readView();
  readBox(at);
  vec4 corner = texelFetch(boxes, at + gl_VertexID);
  gl_Position = vec4(corner.xy, 0.0, corner.z);
}
)";

// Functions of a ray that are the same for all boxes.
const char* const kRayText = R"(
layout(location = 0) out vec4 result;
#if CLIP_PLANES > 0
uniform vec4 clip_planes[CLIP_PLANES];
#endif

// Along the volume's axes: slice k lies at origin + (k + 0.5) * step from the rays' common origin.
struct Ray {
  vec3 origin, step;
  float jitter;  // how much farther the ray's slices lie, see FrameSetup::jitter
  float length;  // slices from sample to sample
};

#if JITTERS
uniform sampler2D noise;
uniform float jitter_share;
float jitterAt(vec2 pixel) {
  return jitter_share * texelFetch(noise, ivec2(pixel) % textureSize(noise, 0), 0).r;
}
#else
float jitterAt(vec2 pixel) { return 0.0; }
#endif

Ray rayAt(vec2 pixel) {
  Ray ray;
  ray.step = step0 + pixel.x * step_dx + pixel.y * step_dy;
  ray.jitter = jitterAt(pixel);
  ray.origin = pixel.x * origin_dx + pixel.y * origin_dy + ray.jitter * ray.step;
#if PERSPECTIVE
  ray.length = length(vec3(pixel.x * pixel_ray.x + pixel_ray.y,
                           pixel.y * pixel_ray.z + pixel_ray.w, 1.0));
#else
  ray.length = 1.0;
#endif
  return ray;
}

// The first slice past the face at distance t. Both boxes at a face compute the same number.
vec3 sliceAt(vec3 t, vec3 step) {
  return mix(floor(t) + 1.0, ceil(t), greaterThan(step, vec3(0.0)));
}
)";

// The slices of this pixel's ray inside the box: [from, to).
const char* const kIntervalText = R"(
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

const char* const kWayText = R"(
// A pixel's way through the box: its slices [from, to), and in the texture the place of slice
// first_k and the way from slice to slice.
ivec2 range;
vec3 first, along;
void enterBox(vec2 pixel, Ray ray) {
  range = slices(ray.origin, ray.step);
  along = textureOrder(ray.step * TEXEL_SCALE) * texel_size;
  first = texel0 + pixel.x * texel_dx + pixel.y * texel_dy + ray.jitter * along;
}
)";

// The voxel planes that this pixel's ray meets in the box, see FrameSetup: sample j of [from, to)
// lies at clamp(start + clamp(j, ends.x, ends.y) * along, 0, size) voxels from the box's lower
// corner, which is texel `corner`. `ends` are the ends of the ray's way through what is shown, if
// they lie in the box. Along the volume's axes.
const char* const kPlanesText = R"(
uniform float planes_a_voxel, end_margin;

// 0 for an outer face, else far beyond any slice.
vec3 inside(int faces) {
  return vec3((faces & 1) != 0 ? 0.0 : 1e30, (faces & 2) != 0 ? 0.0 : 1e30,
              (faces & 4) != 0 ? 0.0 : 1e30);
}

ivec2 planes(vec2 pixel, out vec3 start, out vec3 along, out vec3 size, out vec3 corner,
             out vec2 ends) {
  const float kEdge = 1e-3, kTie = 1.0 + 1e-4;
  vec3 origin = pixel.x * origin_dx + pixel.y * origin_dy;
  vec3 step = step0 + pixel.x * step_dx + pixel.y * step_dy;
  vec3 pace = abs(step);
  vec3 axis = vec3(1.0, 0.0, 0.0);
  if (pace.y > kTie * pace.x) axis = vec3(0.0, 1.0, 0.0);
  if (pace.z > kTie * dot(pace, axis)) axis = vec3(0.0, 0.0, 1.0);
  size = round(box_hi - box_lo);
  // At slice first_k: in texels of the chunk, and in voxels from the box's corner.
  vec3 texel = texel0 + pixel.x * texel_dx + pixel.y * texel_dy;
  texel = turn == 2 ? texel : turn == 0 ? texel.zxy : texel.yzx;
  corner = turn == 2 ? box_corner : turn == 0 ? box_corner.zxy : box_corner.yzx;
  vec3 at = (texel - corner) / TEXEL_SCALE;
  // Slices from first_k on, whole or not.
  vec3 safe = mix(step, vec3(1e-12), lessThan(abs(step), vec3(1e-12)));
  vec3 at_lo = (-kEdge - at) / safe, at_hi = (size + kEdge - at) / safe;
  vec3 enter = min(at_lo, at_hi), leave = max(at_lo, at_hi);
  float from = max(enter.x, max(enter.y, enter.z));
  float to = min(leave.x, min(leave.y, leave.z));
  // The same of those faces alone at which the ray enters and leaves what is shown.
  bvec3 up = greaterThan(safe, vec3(0.0));
  vec3 inside_lo = inside(outer_faces), inside_hi = inside(outer_faces >> 3);
  enter -= mix(inside_hi, inside_lo, up);
  leave += mix(inside_lo, inside_hi, up);
  float enters = max(enter.x, max(enter.y, enter.z));
  float leaves = min(leave.x, min(leave.y, leave.z));
  if (first_slice > 0.0) {
    from = max(from, first_slice - float(first_k));
    enters = max(enters, first_slice - float(first_k));
  }
#if CLIP_PLANES > 0
  for (int i = 0; i < CLIP_PLANES; ++i) {
    float toward = dot(clip_planes[i].xyz, step);
    float t = (clip_planes[i].w - dot(clip_planes[i].xyz, origin)) /
              (abs(toward) < 1e-12 ? 1e-12 : toward) - 0.5 - float(first_k);
    if (toward < 0.0) {
      from = max(from, t);
      enters = max(enters, t);
    } else {
      to = min(to, t);
      leaves = min(leaves, t);
    }
  }
#endif
  ends = vec2(0.0);
  if (!(from <= to)) return ivec2(0);
  // Of the axis, in texels; planes go through texel centres.
  float speed = dot(step, axis) * dot(TEXEL_SCALE, axis);
  float place = dot(at, axis) * dot(TEXEL_SCALE, axis) + dot(fract(corner - 0.5), axis);
  float way = speed < 0.0 ? -planes_a_voxel : planes_a_voxel;
  start = at - place / speed * step;
  along = step / (way * speed);
  bool is_first = enters >= from, is_last = leaves <= to;
  from = way * (place + from * speed);
  to = way * (place + to * speed);
  ends = vec2(is_first ? from : -1e30, is_last ? to : 1e30);
  return ivec2(int(is_first ? floor(from + end_margin) : ceil(from)),
               int(is_last ? ceil(to - end_margin) : floor(to)) + 1);
}
)";

const char* const kCountText = R"(
void main() {
  vec2 pixel = gl_FragCoord.xy + vec2(0.0, first_row);
  enter(pixel, rayAt(pixel));
  result = vec4(float(range.y - range.x));
}
)";

}  // namespace sluice

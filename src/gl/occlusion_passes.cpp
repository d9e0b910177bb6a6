#include "src/gl/occlusion_passes.h"

#include <algorithm>
#include <array>

#include "src/base/error.h"
#include "src/gl/shaders/shader_text.h"

namespace sluice {
namespace {

constexpr const char* kTiles = R"(#version 330 core
uniform sampler2D picture;
layout(location = 0) out float least;
void main() {
  ivec2 last = textureSize(picture, 0) - 1, at = ivec2(gl_FragCoord.xy) * 4;
  least = 1.0;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      least = min(least, texelFetch(picture, min(at + ivec2(x, y), last), 0).a);
}
)";

// A map's pixel is a quadrilateral in the picture, a tile one in the map. Both are tested around
// each other's bounds: in a parallel view they then overlap exactly if the bounds do.
constexpr const char* kMap = R"(#version 330 core
uniform sampler2D tiles;
uniform vec3 clip_x, clip_y, clip_w;  // rows: clip space from (map x, map y, 1)
uniform vec3 map_x, map_y, map_w;     // rows: the map from (clip x, clip y, 1), homogeneous
uniform vec2 picture_size;
layout(location = 0) out float least;
const float kMargin = 0.02;           // of a map's pixel, for rounding
void main() {
  vec2 lo = floor(gl_FragCoord.xy) - kMargin, hi = lo + 1.0 + 2.0 * kMargin;
  vec2 from = vec2(1e9), to = vec2(-1e9);
  least = 0.0;
  for (int i = 0; i < 4; ++i) {
    vec3 corner = vec3((i & 1) == 0 ? lo.x : hi.x, (i & 2) == 0 ? lo.y : hi.y, 1.0);
    float w = dot(clip_w, corner);
    if (w < 1e-6) return;             // at the eye: it hides nothing that is known
    vec2 pixel = (vec2(dot(clip_x, corner), dot(clip_y, corner)) / w * 0.5 + 0.5) * picture_size;
    from = min(from, pixel);
    to = max(to, pixel);
  }
  ivec2 count = textureSize(tiles, 0);
  ivec2 first = ivec2(clamp(floor(from / 4.0), vec2(0.0), vec2(count)));
  ivec2 last = ivec2(clamp(floor(to / 4.0), vec2(-1.0), vec2(count - 1)));
  least = 1.0;                        // of no pixel at all
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x) {
      vec2 near = vec2(1e9), far = vec2(-1e9);
      bool known = true;
      for (int i = 0; i < 4; ++i) {
        vec2 pixel = vec2(x, y) * 4.0 + vec2((i & 1) == 0 ? 0.5 : 3.5, (i & 2) == 0 ? 0.5 : 3.5);
        vec3 clip = vec3(pixel / picture_size * 2.0 - 1.0, 1.0);
        float w = dot(map_w, clip);
        vec2 at = vec2(dot(map_x, clip), dot(map_y, clip)) / w;
        known = known && w > 0.0;
        near = min(near, at);
        far = max(far, at);
      }
      bool overlaps = near.x < hi.x && near.y < hi.y && far.x > lo.x && far.y > lo.y;
      if (overlaps || !known) least = min(least, texelFetch(tiles, ivec2(x, y), 0).r);
    }
}
)";

constexpr const char* kMark = R"(#version 330 core
uniform sampler2D picture;
uniform float opacity;
void main() {
  if (texelFetch(picture, ivec2(gl_FragCoord.xy), 0).a < opacity) discard;
}
)";
static_assert(OcclusionPasses::kTile == 4);  // the shaders assume it

using Row = std::array<double, 3>;

Vec3d asVec(const Row& row) {
  return {row[0], row[1], row[2]};
}

}  // namespace

OcclusionPasses::~OcclusionPasses() {
  for (Plane* plane : {&tiles_, &map_}) {
    gl_.DeleteFramebuffers(1, &plane->framebuffer);
    gl_.DeleteTextures(1, &plane->texture);
  }
  gl_.DeleteFramebuffers(1, &depth_framebuffer_);
  gl_.DeleteRenderbuffers(1, &depth_);
}

void OcclusionPasses::resize(Plane& plane, PictureSize size) {
  if (plane.framebuffer == 0) {
    gl_.GenFramebuffers(1, &plane.framebuffer);
    gl_.GenTextures(1, &plane.texture);
  }
  gl_.BindFramebuffer(GL_FRAMEBUFFER, plane.framebuffer);
  if (plane.size == size) return;
  gl_.BindTexture(GL_TEXTURE_2D, plane.texture);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, size.width, size.height, 0, GL_RED, GL_FLOAT, nullptr);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, plane.texture, 0);
  if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    failSystem("the GL driver cannot draw an opacity map of {} x {} pixels", size.width,
               size.height);
  plane.size = size;
}

void OcclusionPasses::resizeDepth(PictureSize size) {
  if (depth_ == 0) {
    gl_.GenRenderbuffers(1, &depth_);
    gl_.GenFramebuffers(1, &depth_framebuffer_);
  }
  gl_.BindFramebuffer(GL_FRAMEBUFFER, depth_framebuffer_);
  if (depth_size_ == size) return;
  gl_.BindRenderbuffer(GL_RENDERBUFFER, depth_);
  // Two depths suffice: marked or not.
  gl_.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT16, size.width, size.height);
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  const GLenum none = GL_NONE;
  gl_.DrawBuffers(1, &none);
  gl_.ReadBuffer(GL_NONE);
  if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    failSystem("the GL driver cannot draw a depth buffer of {} x {} pixels", size.width,
               size.height);
  depth_size_ = size;
}

void OcclusionPasses::cover(PictureSize size) {
  gl_.Viewport(0, 0, size.width, size.height);
  gl_.Disable(GL_BLEND);
  gl_.Disable(GL_CULL_FACE);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

std::vector<float> OcclusionPasses::leastOpacity(GLuint color, PictureSize size,
                                                 const MapGrid& grid) {
  gl_.Disable(GL_DEPTH_TEST);
  gl_.ActiveTexture(GL_TEXTURE0);
  const PictureSize tiles{(size.width + kTile - 1) / kTile, (size.height + kTile - 1) / kTile};
  resize(tiles_, tiles);
  if (!tile_program_) tile_program_.emplace(gl_, kCoverText, kTiles);
  tile_program_->use();
  tile_program_->set("picture", 0);
  gl_.BindTexture(GL_TEXTURE_2D, color);
  cover(tiles);

  resize(map_, {grid.side, grid.side});
  if (!map_program_) map_program_.emplace(gl_, kCoverText, kMap);
  map_program_->use();
  map_program_->set("tiles", 0);
  const auto& clip = grid.clip_from_map;
  map_program_->set("clip_x", asVec(clip[0]));
  map_program_->set("clip_y", asVec(clip[1]));
  map_program_->set("clip_w", asVec(clip[2]));
  // The inverse up to a factor whose sign is kept, so that w > 0 stays in front of the eye.
  const Vec3d rows[3] = {asVec(clip[0]), asVec(clip[1]), asVec(clip[2])};
  const double sign = dot(rows[0], cross(rows[1], rows[2])) < 0 ? -1 : 1;
  const Vec3d columns[3] = {cross(rows[1], rows[2]) * sign, cross(rows[2], rows[0]) * sign,
                            cross(rows[0], rows[1]) * sign};
  // Divided by the longest column, so that single precision holds the numbers.
  const double largest = std::max({length(columns[0]), length(columns[1]), length(columns[2])});
  constexpr const char* kRows[3] = {"map_x", "map_y", "map_w"};
  for (int i = 0; i < 3; ++i)
    map_program_->set(kRows[i], Vec3d{columns[0][i], columns[1][i], columns[2][i]} / largest);
  const float picture_size[] = {static_cast<float>(size.width), static_cast<float>(size.height)};
  map_program_->set2("picture_size", picture_size);
  gl_.BindTexture(GL_TEXTURE_2D, tiles_.texture);
  cover({grid.side, grid.side});

  std::vector<float> least(static_cast<size_t>(grid.side) * static_cast<size_t>(grid.side));
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.ReadPixels(0, 0, grid.side, grid.side, GL_RED, GL_FLOAT, least.data());
  return least;
}

GLuint OcclusionPasses::markOpaque(GLuint color, PictureSize size, double opacity) {
  resizeDepth(size);
  if (!mark_program_) mark_program_.emplace(gl_, kCoverText, kMark);
  mark_program_->use();
  mark_program_->set("picture", 0);
  mark_program_->set("opacity", opacity);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, color);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthFunc(GL_ALWAYS);
  gl_.DepthMask(GL_TRUE);
  gl_.ClearDepth(1);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  cover(size);
  return depth_;
}

}  // namespace sluice

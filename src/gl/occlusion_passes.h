// OcclusionPasses: GL's part of occlusion (Li 2003, sections 4.2 and 6). The opacity drawn so far
// is projected onto the orthogonal opacity map and brought down to its size, taking least values;
// and pixels that are opaque are marked in a depth buffer, so that fragments behind them end before
// they sample.
//
// The paper projects in passes that each blend one texel of the picture into every pixel of the map
// (MIN). Here are two: the least of each kTile x kTile pixels, then the least of those tiles that a
// map's pixel covers. A tile at the edge of a pixel counts whole, which can only make it less
// opaque.
//
// Owns its framebuffers and textures. One thread, the context's.
#pragma once

#include <optional>
#include <vector>

#include "src/device/frame_values.h"
#include "src/gl/shaders/gl_program.h"

namespace sluice {

class OcclusionPasses {
 public:
  static constexpr int kTile = 4;  // pixels a side

  explicit OcclusionPasses(const GlFunctions& gl) : gl_(gl) {}
  ~OcclusionPasses();
  OcclusionPasses(const OcclusionPasses&) = delete;
  OcclusionPasses& operator=(const OcclusionPasses&) = delete;

  // See Device::leastOpacity. `color` is a texture of the picture. Leaves another framebuffer
  // bound.
  std::vector<float> leastOpacity(GLuint color, PictureSize size, const MapGrid& grid);
  // A depth buffer in which the pixels of `color` whose opacity is at least `opacity` lie nearest
  // and the others farthest. Leaves another framebuffer bound.
  GLuint markOpaque(GLuint color, PictureSize size, double opacity);

 private:
  struct Plane {
    GLuint framebuffer = 0, texture = 0;
    PictureSize size{0, 0};
  };
  void resize(Plane& plane, PictureSize size);
  void resizeDepth(PictureSize size);
  // Draws one triangle over all of the target.
  void cover(PictureSize size);

  const GlFunctions& gl_;
  Plane tiles_, map_;
  GLuint depth_ = 0, depth_framebuffer_ = 0;
  PictureSize depth_size_{0, 0};
  std::optional<GlProgram> tile_program_, map_program_, mark_program_;
};

}  // namespace sluice

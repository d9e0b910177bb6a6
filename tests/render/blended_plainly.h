// Channels blended as one medium by the rule of FrameSetup::others, in plain double loops over the
// pixels and the slices.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "tests/render/render_scene.h"

namespace sluice {

struct PlainChannel {
  std::function<double(Vec3d index)> value;
  TransferFunction transfer;
};

// `dims`: of the finest level, in whose index space `view` is.
inline FloatPicture blendedPlainly(const std::vector<PlainChannel>& channels, Vec3i dims,
                                   const View& view) {
  constexpr int kMostSlices = 600;
  FloatPicture picture;
  picture.width = view.size.width;
  picture.height = view.size.height;
  const double aspect = static_cast<double>(view.size.width) / view.size.height;
  const bool ortho = view.projection == Projection::kOrtho;
  for (int j = 0; j < view.size.height; ++j)
    for (int i = 0; i < view.size.width; ++i) {
      const double u = 2 * (i + 0.5) / view.size.width - 1;
      const double v = 1 - 2 * (j + 0.5) / view.size.height;
      const Vec3d aside =
          view.right * (u * aspect * view.half_height) + view.up * (v * view.half_height);
      const Vec3d start = ortho ? view.eye + aside : view.eye;
      const Vec3d direction = ortho ? view.forward : view.forward + aside;
      Vec3d rgb;
      double opacity = 0;
      for (int k = 0; k < kMostSlices; ++k) {
        const Vec3d p = start + direction * (view.first_depth + (k + 0.5) * view.step);
        bool inside = true;
        for (int a = 0; a < 3; ++a)
          inside = inside && p[a] >= 0 && p[a] < static_cast<double>(dims[a] - 1);
        if (!inside) continue;
        Vec3d light;
        double clear = 1, total = 0;
        for (const PlainChannel& channel : channels) {
          const double value = channel.value(p);
          const double a =
              1 - std::pow(1 - opacityAt(channel.transfer, value), view.step * length(direction));
          light = light + colorAt(channel.transfer, value) * a;
          total += a;
          clear *= 1 - a;
        }
        if (!(total > 0)) continue;
        rgb = rgb + light * ((1 - opacity) * (1 - clear) / total);
        opacity += (1 - opacity) * (1 - clear);
      }
      for (const double each : {rgb.x, rgb.y, rgb.z, opacity})
        picture.rgba.push_back(static_cast<float>(each));
    }
  return picture;
}

}  // namespace sluice

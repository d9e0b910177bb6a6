#include "src/gl/filter_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "src/gl/render_target.h"
#include "src/gl/shaders/gl_program.h"
#include "src/gl/shaders/shader_text.h"
#include "src/gl/texture_pool.h"

namespace sluice {
namespace {

// One alone of 61 samples lies at a 256th of the way between the texels.
constexpr int kSamples = 61;

constexpr const char* kSampleLine = R"(#version 330 core
uniform sampler3D texels;
uniform float samples;
layout(location = 0) out vec4 value;
void main() { value = textureLod(texels, vec3(0.25 + 0.5 * gl_FragCoord.x / samples, 0.5, 0.5), 0.0); }
)";

}  // namespace

bool filtersExactly(const GlFunctions& gl) {
  constexpr double kExact = 1e-4;
  RenderTarget target(gl, false);
  target.resize({kSamples, 1});
  target.attachSecond(false);
  gl.Viewport(0, 0, kSamples, 1);
  gl.Disable(GL_BLEND);
  gl.Disable(GL_CULL_FACE);
  gl.Disable(GL_DEPTH_TEST);

  TexturePool pool(gl);
  gl.ActiveTexture(GL_TEXTURE0);
  GlProgram program(gl, kCoverText, kSampleLine);
  program.use();
  program.set("texels", 0);
  program.set("samples", static_cast<double>(kSamples));
  double largest = 0;
  const auto look = [&](DeviceType type, std::span<const std::byte> texels) {
    constexpr Vec3i kTwo{2, 1, 1};
    const GLuint texture = pool.take(kTwo, {type}, texels);
    gl.BindTexture(GL_TEXTURE_3D, texture);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    std::vector<float> values;
    target.read(GL_COLOR_ATTACHMENT0, values);
    pool.giveBack(texture, kTwo, {type});
    gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    for (size_t i = 0; i < kSamples; ++i) {
      const double part = (static_cast<double>(i) + 0.5) / kSamples;
      largest = std::max(largest, std::abs(values[4 * i] - part));
    }
  };
  // Drivers may treat both kinds in their own ways.
  constexpr std::array<float, 2> kFloats{0, 1};
  constexpr std::array<uint8_t, 2> kBytes{0, 255};
  look(DeviceType::kF32, std::as_bytes(std::span(kFloats)));
  look(DeviceType::kU8, std::as_bytes(std::span(kBytes)));
  return largest < kExact;
}

}  // namespace sluice

#include "src/gl/look_textures.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "src/device/chunk_texels.h"
#include "src/device/pictures/blue_noise.h"
#include "src/gl/shaders/shading.h"

namespace sluice {
namespace {

constexpr GLenum kSumsUnit = 5, kLightUnit = 7;

// Filter of the bound table's texture.
void setFilter(const GlFunctions& gl, GLint filter) {
  for (const GLenum way : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    gl.TexParameteri(GL_TEXTURE_2D, way, filter);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    gl.TexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
}

}  // namespace

LookTextures::LookTextures(const GlFunctions& gl) : gl_(gl) {
  for (GLuint* const texture : {&look_up_, &factors_, &expected_, &sums_, &light_, &noise_})
    gl_.GenTextures(1, texture);
}

LookTextures::~LookTextures() {
  for (const GLuint texture : {look_up_, factors_, expected_, sums_, light_, noise_})
    gl_.DeleteTextures(1, &texture);
}

void LookTextures::uploadLookUp(const FrameSetup& setup, const ShaderVariant& variant) {
  LookUpKey key = lookUpKey(setup);
  if (look_up_key_ == key) return;
  const auto width = static_cast<GLsizei>(setup.look_up->rgba.size() / 4);
  // The opacity of a label depends on the share of a texel that has it: the shader does the rest.
  std::vector<float> texels = variant.labels ? setup.look_up->rgba : lookUpTexels(key);
  look_up_key_ = std::move(key);
  // Tables of labels may have more entries than a texture is wide; LABEL_ROW in the shader.
  constexpr GLsizei kLabelRow = 4096;
  const GLsizei row = setup.look_up->labels ? std::min(width, kLabelRow) : width;
  const GLsizei rows = (width + row - 1) / row;
  // The last row may be filled in part.
  texels.resize(4 * static_cast<size_t>(row) * static_cast<size_t>(rows));
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, row, rows, 0, GL_RGBA, GL_FLOAT, texels.data());
  if (!variant.factor_table) return;
  gl_.BindTexture(GL_TEXTURE_2D, factors_);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, width, variant.gradient_rows, 0, GL_RED, GL_FLOAT,
                 setup.look_up->factors.data());
  gl_.BindTexture(GL_TEXTURE_2D, look_up_);
}

void LookTextures::setLookUp(const FrameSetup& setup, const ShaderVariant& variant,
                             GlProgram& program, const LookUnits& units) {
  const auto entries = static_cast<GLsizei>(setup.look_up->rgba.size() / 4);
  const bool interpolates = setup.look_up->interpolates || !traitsOf(setup.mode).has_colors;
  gl_.ActiveTexture(GL_TEXTURE0 + units.look_up);
  gl_.BindTexture(GL_TEXTURE_2D, look_up_);
  uploadLookUp(setup, variant);
  setFilter(gl_, interpolates ? GL_LINEAR : GL_NEAREST);
  if (variant.factor_table) {
    gl_.ActiveTexture(GL_TEXTURE0 + units.factors);
    gl_.BindTexture(GL_TEXTURE_2D, factors_);
    setFilter(gl_, GL_LINEAR);
    program.set("factors", static_cast<int>(units.factors));
  }
  // Entry e covers [e, e + 1) / entries of the texture.
  const ValueRange range = setup.look_up->device_range;
  // A look of one value has no span to divide by; all values then take the first entry.
  const double span = range.hi - range.lo;
  const double per_device = span > 0 ? (entries - 1) / span : 0;
  const double scale = valueScale(setup.type);
  program.set("look_up", static_cast<int>(units.look_up));
  program.set("label_entries", static_cast<int>(entries));
  const std::array<float, 4> line = {static_cast<float>(scale * per_device / entries),
                                     static_cast<float>((0.5 - range.lo * per_device) / entries),
                                     static_cast<float>(range.lo / scale),
                                     static_cast<float>(range.hi / scale)};
  program.set4("entries", line.data(), 1);
}

void LookTextures::setSums(const FrameSetup& setup, GlProgram& program) {
  const LookUp& look_up = *setup.look_up;
  gl_.ActiveTexture(GL_TEXTURE0 + kSumsUnit);
  gl_.BindTexture(GL_TEXTURE_2D, sums_);
  if (summed_look_ != setup.look_up) {
    integrated_ = integratedLook(look_up);
    summed_look_ = setup.look_up;
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32I, integrated_.entries(), 2, 0, GL_RGBA_INTEGER,
                   GL_INT, integrated_.sums.data());
  }
  setFilter(gl_, GL_NEAREST);
  program.set("sums", static_cast<int>(kSumsUnit));
  const double length = look_up.magnitudes.empty() ? setup.slice_length : 1;
  program.set2("sums_line", integrated_.entries() - 1, integrated_.unit * length);
  program.set2("one_value", integrated_.one_value, integrated_.near_entry);
  const double scale = valueScale(setup.type);
  const std::array<float, 4> line = {static_cast<float>(scale * integrated_.entries_a_value),
                                     static_cast<float>(integrated_.first), 0, 0};
  program.set4("entries", line.data(), 1);
}

void LookTextures::setLight(const FrameSetup& setup, GlProgram& program) {
  const LightVolume& light = *setup.light;
  gl_.ActiveTexture(GL_TEXTURE0 + kLightUnit);
  gl_.BindTexture(GL_TEXTURE_3D, light_);
  if (light_volume_ != setup.light) {
    light_volume_ = setup.light;
    for (const GLenum way : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      gl_.TexParameteri(GL_TEXTURE_3D, way, GL_LINEAR);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
      gl_.TexParameteri(GL_TEXTURE_3D, wrap, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAX_LEVEL, 0);
    gl_.TexImage3D(GL_TEXTURE_3D, 0, GL_RG16, static_cast<GLsizei>(light.dims.x),
                   static_cast<GLsizei>(light.dims.y), static_cast<GLsizei>(light.dims.z), 0, GL_RG,
                   GL_UNSIGNED_SHORT, light.texels.data());
  }
  program.set("light", static_cast<int>(kLightUnit));
  // Texel t lies at (t + 1/2) / texels of the texture.
  const Vec3d texels = toDouble(light.dims);
  const Vec3d origin = setup.rays.origin0 * light.scale + light.offset + Vec3d{0.5, 0.5, 0.5};
  program.set("light_scale", light.scale / texels);
  program.set("light_offset", origin / texels);
}

void LookTextures::setJitter(const FrameSetup& setup, GlProgram& program) {
  gl_.ActiveTexture(GL_TEXTURE0 + kNoiseUnit);
  gl_.BindTexture(GL_TEXTURE_2D, noise_);
  if (!has_noise_)
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, kBlueNoiseSide, kBlueNoiseSide, 0, GL_RED, GL_FLOAT,
                   blueNoise().data());
  has_noise_ = true;
  setFilter(gl_, GL_NEAREST);
  program.set("noise", static_cast<int>(kNoiseUnit));
  program.set("jitter_share", setup.jitter);
}

void LookTextures::setSecondNumber(const FrameSetup& setup, const ShaderVariant& variant,
                                   GlProgram& program, const LookUnits& units) {
  if (variant.spread) setExpected(setup, units.expected, program);
  if (variant.shares) program.set("share_unit", valueScale(setup.type) / wholeShare(setup.type));
}

void LookTextures::setExpected(const FrameSetup& setup, GLenum unit, GlProgram& program) {
  const ExpectedLookPtr& look = setup.look_up->expected;
  gl_.ActiveTexture(GL_TEXTURE0 + unit);
  gl_.BindTexture(GL_TEXTURE_2D, expected_);
  if (expected_look_ != look)
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, look->entries, look->rows, 0, GL_RGBA, GL_FLOAT,
                   look->rgba.data());
  expected_look_ = look;
  setFilter(gl_, GL_LINEAR);
  program.set("expected", static_cast<int>(unit));
  // Entry e lies at (e + 1/2) / entries of the texture.
  const ValueRange range = look->device_range;
  const double span = range.hi - range.lo, scale = valueScale(setup.type);
  const double per_device = span > 0 ? (look->entries - 1) / span : 0;
  const std::array<float, 4> line = {
      static_cast<float>(scale * per_device / look->entries),
      static_cast<float>((0.5 - range.lo * per_device) / look->entries),
      static_cast<float>(span > 0 ? scale / span : 0), static_cast<float>(look->rows)};
  program.set4("expected_line", line.data(), 1);
  program.set("expected_length", setup.slice_length);
}

}  // namespace sluice

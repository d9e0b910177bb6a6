// LookTextures: the tables of a look as textures: its colours and opacities, the factors of its
// gradients, the expected look of coarse voxels, and the sums of a pre-integrated look; and the
// light volume of a frame and its noise. A table is uploaded only if it is not in its texture yet.
// The context must be current in every call.
#pragma once

#include "src/device/shading/integrated_look.h"
#include "src/device/shading/look_up_texels.h"
#include "src/gl/contexts/gl_functions.h"
#include "src/gl/shaders/gl_program.h"
#include "src/gl/shaders/shaders.h"

namespace sluice {

// Units of textures that all programs may have; others belong to what they draw.
inline constexpr GLenum kBoxUnit = 2, kNoiseUnit = 8;

struct LookUnits {
  GLenum look_up = 1, factors = 3, expected = 4;
};

class LookTextures {
 public:
  explicit LookTextures(const GlFunctions& gl);
  ~LookTextures();
  LookTextures(const LookTextures&) = delete;
  LookTextures& operator=(const LookTextures&) = delete;

  // Each binds its texture and tells the program, which is in use, how to read it.
  void setLookUp(const FrameSetup& setup, const ShaderVariant& variant, GlProgram& program,
                 const LookUnits& units = {});
  // Sets what a variant for chunks with two numbers a texel reads; nothing for others.
  void setSecondNumber(const FrameSetup& setup, const ShaderVariant& variant, GlProgram& program,
                       const LookUnits& units = {});
  // Called after setLookUp(), whose line of entries it replaces.
  void setSums(const FrameSetup& setup, GlProgram& program);
  // Requires: the frame has a light volume.
  void setLight(const FrameSetup& setup, GlProgram& program);
  // Requires: the frame jitters.
  void setJitter(const FrameSetup& setup, GlProgram& program);

 private:
  void setExpected(const FrameSetup& setup, GLenum unit, GlProgram& program);
  // Uploads the look-up into the bound texture, and factors into theirs.
  void uploadLookUp(const FrameSetup& setup, const ShaderVariant& variant);

  const GlFunctions& gl_;
  GLuint look_up_ = 0, factors_ = 0, expected_ = 0, sums_ = 0, light_ = 0, noise_ = 0;
  // The textures' contents; without a look: none yet.
  LookUpKey look_up_key_;
  ExpectedLookPtr expected_look_;
  LightVolumePtr light_volume_;
  bool has_noise_ = false;
  LookUpPtr summed_look_;  // the look-up that integrated_ is made of
  IntegratedLook integrated_;
};

}  // namespace sluice

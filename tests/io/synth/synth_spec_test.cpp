#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/synth/synth_source.h"
#include "src/base/error.h"

namespace sluice {
namespace {

TEST(SynthSpec, isTakenBack) {
  const SynthOptions options = parseSynthSpec(
      "synth:flow,dims=300x200x100,type=f32,steps=12,seed=9,share=0.125,spacing=1x0.5x2");
  EXPECT_EQ(options.kind, SynthKind::kFlow);
  EXPECT_EQ(options.dims, (Vec3i{300, 200, 100}));
  EXPECT_EQ(options.type, VoxelType::kF32);
  EXPECT_EQ(options.time_steps, 12);
  EXPECT_EQ(options.seed, 9U);
  EXPECT_EQ(options.object_share, 0.125);
  EXPECT_EQ(options.spacing, (Vec3d{1, 0.5, 2}));
  EXPECT_EQ(specOf(parseSynthSpec(specOf(options))), specOf(options));
  EXPECT_EQ(parseSynthSpec("shells").kind, SynthKind::kShells);
  EXPECT_TRUE(isSynthSpec("synth:cube"));
  EXPECT_FALSE(isSynthSpec("cube.raw"));
  for (const SynthKind kind : synthKinds()) {
    EXPECT_EQ(parseSynthKind(name(kind)), kind);
    EXPECT_FALSE(descriptionOf(kind).empty());
  }
}

TEST(SynthSpec, refusesWhatItCannotMakeInOneLine) {
  for (const char* spec : {"synth:",
                           "synth:cone",

                           "cube,dims=1x2",
                           "cube,dims=1x2x3x4",
                           "cube,dims=0x1x1",
                           "cube,dims=-1x1x1",
                           "cube,dims=9999999999x9999999999x9999999999",
                           "cube,type=i16",
                           "parts,type=f32",
                           "parts,levels=2",
                           "cube,type=x",
                           "cube,steps=2",
                           "flow,steps=0",
                           "flow,steps=10001",
                           "slab,share=0",
                           "slab,share=1.5",
                           "slab,share=nan",
                           "sparse,share=0.5",
                           "cube,seed=-1",
                           "cube,size=3",
                           "cube,spacing=0x1x1",
                           "cube,spacing=1xinfx1",
                           "cube,dims"}) {
    try {
      openSynth(parseSynthSpec(spec));
      ADD_FAILURE() << spec << " was taken";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("expected")) << spec;
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n"))) << spec;
    }
  }
}

}  // namespace
}  // namespace sluice

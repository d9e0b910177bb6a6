// Whether the driver interpolates exactly, and how the device takes it.
#include "src/gl/filter_check.h"

#include <gtest/gtest.h>

#include "tests/gl/test_device.h"

namespace sluice {
namespace {

TEST(FilterCheckTest, softwareIsExact) {
  const std::unique_ptr<GlContext> context = createContext(GlChoice::kAuto);
  if (!context->isSoftware()) GTEST_SKIP() << context->renderer() << " is no software";
  const GlFunctions& gl = context->functions();
  GLuint vertices = 0;
  gl.GenVertexArrays(1, &vertices);
  gl.BindVertexArray(vertices);
  EXPECT_TRUE(filtersExactly(gl));
  gl.DeleteVertexArrays(1, &vertices);
}

TEST(FilterCheckTest, textureMemoryIsTheProcessesInSoftwareAlone) {
  std::unique_ptr<GlContext> context = createContext(GlChoice::kAuto);
  const bool is_software = context->isSoftware();
  const GlDevice device(std::move(context));
  EXPECT_EQ(device.limits().texels, is_software ? TexelPlace::kInMemory : TexelPlace::kOnDevice);
}

}  // namespace
}  // namespace sluice

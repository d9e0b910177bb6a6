// Whether the driver interpolates exactly, and how the device takes it.
#include "src/gl/filter_check.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/gl/test_device.h"

namespace sluice {
namespace {

struct Findings {
  bool is_software = false, filters_exactly = false;
};
Findings look() {
  const std::unique_ptr<GlContext> context = createContext(GlChoice::kAuto);
  const GlFunctions& gl = context->functions();
  GLuint vertices = 0;
  gl.GenVertexArrays(1, &vertices);
  gl.BindVertexArray(vertices);
  const Findings found{context->isSoftware(), filtersExactly(gl)};
  gl.DeleteVertexArrays(1, &vertices);
  return found;
}

TEST(FilterCheckTest, softwareIsExact) {
  const Findings found = look();
  if (!found.is_software) GTEST_SKIP() << "the driver is no software";
  EXPECT_TRUE(found.filters_exactly);
}

// Mesa's software samples bytes in bytes if the environment lets it: in a process of its own, since
// it reads the environment once. Other drivers have nothing to show.
TEST(FilterCheckTest, coarseSoftwareIsFound) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        setenv("GALLIVM_PERF", "", 1);
        const Findings found = look();
        _exit(!found.is_software || !found.filters_exactly ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(FilterCheckTest, textureMemoryIsTheProcessesInSoftwareAlone) {
  std::unique_ptr<GlContext> context = createContext(GlChoice::kAuto);
  const bool is_software = context->isSoftware();
  const GlDevice device(std::move(context));
  EXPECT_EQ(device.limits().texels, is_software ? TexelPlace::kInMemory : TexelPlace::kOnDevice);
}

}  // namespace
}  // namespace sluice

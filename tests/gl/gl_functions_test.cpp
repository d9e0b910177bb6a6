#include "src/gl/contexts/gl_functions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "src/base/error.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// A GL library of no use: it tells a version and one extension, and all else does nothing.
template <int kMajor, int kMinor>
const GLubyte* APIENTRY tellVersion(GLenum /*what*/) {
  static const std::string text = fmt::format("{}.{} (Core Profile) Test", kMajor, kMinor);
  return reinterpret_cast<const GLubyte*>(text.c_str());
}
void doNothing() {}

template <int kMajor, int kMinor>
GlLoader libraryWithout(std::string_view missing) {
  return [missing](const char* name) -> void* {
    const std::string_view wanted = name;
    if (wanted == missing) return nullptr;
    if (wanted == "glGetString") return reinterpret_cast<void*>(&tellVersion<kMajor, kMinor>);
    return reinterpret_cast<void*>(&doNothing);
  };
}

std::string errorOf(const GlLoader& loader) {
  try {
    loadGlFunctions(loader);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(GlFunctions, namesARequiredFunctionThatIsMissing) {
  for (const char* name : {"glGetString", "glTexSubImage3D", "glLinkProgram", "glUniform4fv"})
    EXPECT_THAT(errorOf(libraryWithout<3, 3>(name)), HasSubstr(name));
  EXPECT_EQ(errorOf(libraryWithout<3, 3>("")), "no error");
}

TEST(GlFunctions, refusesAnOlderVersion) {
  EXPECT_THAT(errorOf(libraryWithout<3, 2>("")), HasSubstr("3.2 (Core Profile) Test"));
  EXPECT_THAT(errorOf(libraryWithout<2, 1>("")), HasSubstr("3.3 is needed"));
}

}  // namespace
}  // namespace sluice

#include "src/gl/gl_functions.h"

#include <set>
#include <string>
#include <string_view>

#include "src/base/error.h"

namespace sluice {
namespace {

template <class Function>
void loadRequired(Function& function, const GlLoader& loader, const char* name) {
  function = reinterpret_cast<Function>(loader(name));
  if (function == nullptr) fail("the OpenGL library has no function {}, sluice needs it", name);
}

std::set<std::string, std::less<>> extensionsOf(const GlFunctions& gl) {
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  std::set<std::string, std::less<>> extensions;
  for (GLint i = 0; i < count; ++i) {
    const GLubyte* const text = gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i));
    if (text != nullptr) extensions.emplace(reinterpret_cast<const char*>(text));
  }
  return extensions;
}

// major * 10 + minor from the text, since GL_MAJOR_VERSION itself is an error before GL 3.0.
int versionOf(const GlFunctions& gl) {
  const GLubyte* const text = gl.GetString(GL_VERSION);
  if (text == nullptr) fail("the OpenGL library tells no version: no context is current");
  const std::string_view version(reinterpret_cast<const char*>(text));
  const bool is_plain = version.size() >= 3 && version[0] >= '1' && version[0] <= '9' &&
                        version[1] == '.' && version[2] >= '0' && version[2] <= '9';
  const int number = is_plain ? (version[0] - '0') * 10 + (version[2] - '0') : 0;
  if (number < 33) fail("OpenGL 3.3 is needed, this context is '{}'", version);
  return number;
}

}  // namespace

GlFunctions loadGlFunctions(const GlLoader& loader) {
  GlFunctions gl;
  loadRequired(gl.GetString, loader, "glGetString");
  const int version = versionOf(gl);
#define SLUICE_GL_LOAD(name, NAME) loadRequired(gl.name, loader, "gl" #name);
  SLUICE_GL_REQUIRED_FUNCTIONS(SLUICE_GL_LOAD)
#undef SLUICE_GL_LOAD
  const auto extensions = extensionsOf(gl);
#define SLUICE_GL_LOAD(name, NAME, since, extension)        \
  if (version >= (since) || extensions.contains(extension)) \
    gl.name = reinterpret_cast<PFNGL##NAME##PROC>(loader("gl" #name));
  SLUICE_GL_OPTIONAL_FUNCTIONS(SLUICE_GL_LOAD)
#undef SLUICE_GL_LOAD
  return gl;
}

}  // namespace sluice

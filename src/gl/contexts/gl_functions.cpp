#include "src/gl/contexts/gl_functions.h"

#include <string_view>

#include "src/base/error.h"

namespace sluice {
namespace {

template <class Function>
void loadRequired(Function& function, const GlLoader& loader, const char* name) {
  function = reinterpret_cast<Function>(loader(name));
  if (function == nullptr)
    failSystem("the OpenGL library has no function {}, sluice needs it", name);
}

// major * 10 + minor from the text, since GL_MAJOR_VERSION itself is an error before GL 3.0.
void requireVersion(const GlFunctions& gl) {
  const GLubyte* const text = gl.GetString(GL_VERSION);
  if (text == nullptr) failSystem("the OpenGL library tells no version: no context is current");
  const std::string_view version(reinterpret_cast<const char*>(text));
  const bool is_plain = version.size() >= 3 && version[0] >= '1' && version[0] <= '9' &&
                        version[1] == '.' && version[2] >= '0' && version[2] <= '9';
  const int number = is_plain ? (version[0] - '0') * 10 + (version[2] - '0') : 0;
  if (number < 33) failSystem("OpenGL 3.3 is needed, this context is '{}'", version);
}

}  // namespace

GlFunctions loadGlFunctions(const GlLoader& loader) {
  GlFunctions gl;
  loadRequired(gl.GetString, loader, "glGetString");
  requireVersion(gl);
#define SLUICE_GL_LOAD(name, NAME) loadRequired(gl.name, loader, "gl" #name);
  SLUICE_GL_FUNCTIONS(SLUICE_GL_LOAD)
#undef SLUICE_GL_LOAD
  return gl;
}

}  // namespace sluice

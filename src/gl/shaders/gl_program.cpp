#include "src/gl/shaders/gl_program.h"

#include <array>

#include "src/base/error.h"

namespace sluice {
namespace {

GLuint compile(const GlFunctions& gl, GLenum kind, const std::string& source) {
  const GLuint shader = gl.CreateShader(kind);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  std::array<char, 1024> log{};
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl.DeleteShader(shader);
  failSystem("the GL driver refuses a shader: {}", log.data());
}

}  // namespace

GlProgram::GlProgram(const GlFunctions& gl, const std::string& vertex, const std::string& fragment)
    : gl_(gl), program_(gl.CreateProgram()) {
  for (const auto& [kind, source] :
       {std::pair(GL_VERTEX_SHADER, &vertex), std::pair(GL_FRAGMENT_SHADER, &fragment)}) {
    const GLuint shader = compile(gl, static_cast<GLenum>(kind), *source);
    gl.AttachShader(program_, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program_);
  GLint linked = 0;
  gl.GetProgramiv(program_, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return;
  std::array<char, 1024> log{};
  gl.GetProgramInfoLog(program_, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl.DeleteProgram(program_);
  failSystem("the GL driver refuses to link a program: {}", log.data());
}

GlProgram::~GlProgram() {
  gl_.DeleteProgram(program_);
}

void GlProgram::ofChannel(size_t channel) {
  suffix_ = fmt::format("_{}", channel);
}

GLint GlProgram::locate(const char* name) {
  // The text of a channel has its own names, see ofChannel().
  const std::string whole = name + suffix_;
  // Asking the driver for a location takes longer than setting the number.
  const auto found = locations_.find(whole);
  if (found != locations_.end()) return found->second;
  return locations_.emplace(whole, gl_.GetUniformLocation(program_, whole.c_str())).first->second;
}

void GlProgram::set(const char* name, int value) {
  gl_.Uniform1i(locate(name), value);
}
void GlProgram::set(const char* name, double value) {
  gl_.Uniform1f(locate(name), static_cast<GLfloat>(value));
}
void GlProgram::set(const char* name, Vec3d v) {
  gl_.Uniform3f(locate(name), static_cast<GLfloat>(v.x), static_cast<GLfloat>(v.y),
                static_cast<GLfloat>(v.z));
}
void GlProgram::set2(const char* name, const float* values) {
  gl_.Uniform2fv(locate(name), 1, values);
}

void GlProgram::set2(const char* name, double x, double y) {
  gl_.Uniform2f(locate(name), static_cast<GLfloat>(x), static_cast<GLfloat>(y));
}
void GlProgram::set1(const char* name, const float* values, int count) {
  gl_.Uniform1fv(locate(name), count, values);
}
void GlProgram::set4(const char* name, const float* values, int count) {
  gl_.Uniform4fv(locate(name), count, values);
}
void GlProgram::set3(const char* name, const float* values, int count) {
  gl_.Uniform3fv(locate(name), count, values);
}

}  // namespace sluice

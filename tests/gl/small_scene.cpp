#include "tests/gl/small_scene.h"

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr const char* kTriangle = R"(#version 330 core
const vec2 corners[3] = vec2[3](vec2(-1, -1), vec2(1, -1), vec2(-1, 1));
void main() { gl_Position = vec4(corners[gl_VertexID], 0, 1); })";
constexpr const char* kWholePicture = R"(#version 330 core
const vec2 corners[3] = vec2[3](vec2(-1, -1), vec2(3, -1), vec2(-1, 3));
void main() { gl_Position = vec4(corners[gl_VertexID], 0, 1); })";
constexpr const char* kPlain = R"(#version 330 core
uniform vec4 color;
out vec4 shown;
void main() { shown = color; })";
constexpr const char* kSampled = R"(#version 330 core
uniform sampler3D voxels;
uniform float count;
out vec4 shown;
void main() { shown = texture(voxels, vec3(gl_FragCoord.x / count, 0.5, 0.5)); })";

GLuint compile(const GlFunctions& gl, GLenum stage, const char* source) {
  const GLuint shader = gl.CreateShader(stage);
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  GLint compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (!compiled) fail("the test's shader does not compile");
  return shader;
}

// A program, a vertex array and a floating-point framebuffer of width x height, all bound.
class Stage {
 public:
  Stage(const GlFunctions& gl, const char* vertex, const char* fragment, int width, int height)
      : gl_(gl), width_(width), height_(height), program_(gl.CreateProgram()) {
    for (const GLuint shader :
         {compile(gl, GL_VERTEX_SHADER, vertex), compile(gl, GL_FRAGMENT_SHADER, fragment)}) {
      gl.AttachShader(program_, shader);
      gl.DeleteShader(shader);
    }
    gl.LinkProgram(program_);
    gl.UseProgram(program_);
    gl.GenVertexArrays(1, &vertices_);
    gl.BindVertexArray(vertices_);
    gl.GenTextures(1, &picture_);
    gl.BindTexture(GL_TEXTURE_2D, picture_);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
    gl.GenFramebuffers(1, &framebuffer_);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_, 0);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      fail("the test's framebuffer is incomplete");
    gl.Viewport(0, 0, width, height);
  }
  ~Stage() {
    gl_.DeleteFramebuffers(1, &framebuffer_);
    gl_.DeleteTextures(1, &picture_);
    gl_.DeleteVertexArrays(1, &vertices_);
    gl_.DeleteProgram(program_);
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  GLint uniform(const char* name) const { return gl_.GetUniformLocation(program_, name); }
  std::vector<Rgba> drawAndRead() const {
    gl_.DrawArrays(GL_TRIANGLES, 0, 3);
    std::vector<Rgba> pixels(static_cast<size_t>(width_) * static_cast<size_t>(height_));
    gl_.ReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, pixels.data());
    const GLenum error = gl_.GetError();
    if (error != GL_NO_ERROR) fail("the test's drawing gives GL error {:#x}", error);
    return pixels;
  }

 private:
  const GlFunctions& gl_;
  const int width_, height_;
  const GLuint program_;
  GLuint vertices_ = 0, picture_ = 0, framebuffer_ = 0;
};

}  // namespace

std::vector<Rgba> drawTriangle(const GlContext& context, Rgba clear, Rgba color) {
  const GlFunctions& gl = context.functions();
  const Stage stage(gl, kTriangle, kPlain, kSceneSize, kSceneSize);
  gl.ClearBufferfv(GL_COLOR, 0, clear.data());
  gl.Uniform4fv(stage.uniform("color"), 1, color.data());
  return stage.drawAndRead();
}

std::vector<float> sampleAcross(const GlContext& context, unsigned char left, unsigned char right,
                                int count) {
  const GlFunctions& gl = context.functions();
  const Stage stage(gl, kWholePicture, kSampled, count, 1);
  GLuint voxels = 0;
  gl.GenTextures(1, &voxels);
  gl.BindTexture(GL_TEXTURE_3D, voxels);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    gl.TexParameteri(GL_TEXTURE_3D, axis, GL_CLAMP_TO_EDGE);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    gl.TexParameteri(GL_TEXTURE_3D, filter, GL_LINEAR);
  const std::array<unsigned char, 8> texels{left, right, left, right, left, right, left, right};
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage3D(GL_TEXTURE_3D, 0, GL_R8, 2, 2, 2, 0, GL_RED, GL_UNSIGNED_BYTE, texels.data());
  gl.Uniform1i(stage.uniform("voxels"), 0);
  gl.Uniform1f(stage.uniform("count"), static_cast<float>(count));
  std::vector<float> result;
  for (const Rgba& pixel : stage.drawAndRead()) result.push_back(pixel[0] * 255);
  gl.DeleteTextures(1, &voxels);
  return result;
}

}  // namespace sluice

#include "src/view/window/texture.h"

#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>

#include <utility>

namespace sluice {
namespace {

// The functions come from GLFW, because libGL promises symbols for the first versions of OpenGL
// alone.
template <class Function>
Function find(const char* name) {
  return reinterpret_cast<Function>(glfwGetProcAddress(name));
}

void removeFence(void* fence) {
  if (fence != nullptr) find<PFNGLDELETESYNCPROC>("glDeleteSync")(static_cast<GLsync>(fence));
}

}  // namespace

Texture::~Texture() {
  drop();
}

void* Texture::id() const {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): what ImGui's ids are
  return reinterpret_cast<void*>(static_cast<uintptr_t>(shown_ ? shown_->texture : name_));
}

void Texture::letGo() {
  if (!shown_) return;
  const ScreenImage image = *std::exchange(shown_, std::nullopt);
  const GLsync seen = find<PFNGLFENCESYNCPROC>("glFenceSync")(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glFlush();  // else a thread that waits for the fence may wait for ever
  // The renderer waits for this fence before it draws over the texture.
  removeFence(image.seen->exchange(seen));
  if (!image.is_let_go->exchange(true)) return;
  // The renderer has ended, and nobody else holds the texture.
  removeFence(image.drawn);
  removeFence(image.seen->load());
  glDeleteTextures(1, &image.texture);
}

void Texture::drop() {
  letGo();
  if (name_ != 0) glDeleteTextures(1, &name_);
  name_ = 0;
  width_ = height_ = 0;
}

void Texture::swap(Texture& other) {
  std::swap(name_, other.name_);
  std::swap(shown_, other.shown_);
  std::swap(width_, other.width_);
  std::swap(height_, other.height_);
}

void Texture::show(const ScreenImage& image) {
  // The old picture goes back first, so that the renderer has its texture for the next one.
  letGo();
  // The driver's commands wait, this thread does not.
  find<PFNGLWAITSYNCPROC>("glWaitSync")(static_cast<GLsync>(image.drawn), 0, GL_TIMEOUT_IGNORED);
  shown_ = image;
}

void Texture::set(int width, int height, const std::vector<uint8_t>& rgba) {
  letGo();
  if (name_ == 0) {
    glGenTextures(1, &name_);
    glBindTexture(GL_TEXTURE_2D, name_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  glBindTexture(GL_TEXTURE_2D, name_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  // New storage for a texture costs more than new contents, and most pictures have the size of the
  // last one.
  if (width == width_ && height == height_) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  } else {
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 rgba.data());
  }
  width_ = width;
  height_ = height;
}

}  // namespace sluice

#include "src/view/window/texture.h"

#include <GLFW/glfw3.h>

namespace sluice {

Texture::~Texture() {
  if (name_ != 0) glDeleteTextures(1, &name_);
}

void* Texture::id() const {
  return reinterpret_cast<void*>(static_cast<uintptr_t>(name_));
}

void Texture::set(int width, int height, const std::vector<uint8_t>& rgba) {
  if (name_ == 0) {
    glGenTextures(1, &name_);
    glBindTexture(GL_TEXTURE_2D, name_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    constexpr GLint kClampToEdge = 0x812F;  // of OpenGL 1.2, which old headers do not have
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, kClampToEdge);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, kClampToEdge);
  }
  glBindTexture(GL_TEXTURE_2D, name_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
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

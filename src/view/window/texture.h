// Texture: pixels on their way to the screen. The window's thread, its context current.
#pragma once

#include <cstdint>
#include <vector>

namespace sluice {

class Texture {
 public:
  Texture() = default;
  ~Texture();
  Texture(const Texture&) = delete;
  Texture& operator=(const Texture&) = delete;

  // width * height * 4 bytes, red first, rows from the top. Smooth where it is shown larger.
  void set(int width, int height, const std::vector<uint8_t>& rgba);
  // For ImGui; null before the first set().
  void* id() const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  unsigned name_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace sluice

// Texture: pixels on their way to the screen. The window's thread, its context current.
#pragma once

#include <sluice/screen.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace sluice {

class Texture {
 public:
  Texture() = default;
  ~Texture();
  Texture(const Texture&) = delete;
  Texture& operator=(const Texture&) = delete;

  // width * height * 4 bytes, red first, rows from the top. Smooth if it is shown larger.
  void set(int width, int height, const std::vector<uint8_t>& rgba);
  // A picture that the desk drew: shown as it is, until the next set(), show() or drop().
  void show(const ScreenImage& image);
  // Shows nothing.
  void drop();
  void swap(Texture& other);
  // The texture's identifier in ImGui; null before the first set().
  void* id() const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  void letGo();

  unsigned name_ = 0;                 // our own
  std::optional<ScreenImage> shown_;  // in its place
  int width_ = 0, height_ = 0;
};

}  // namespace sluice

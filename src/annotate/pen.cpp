#include "src/annotate/pen.h"

#include <cairo.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr double kRimWidth = 0.16;  // share of an em, on either side

void setColor(cairo_t* cairo, Vec3d rgb) {
  cairo_set_source_rgb(cairo, rgb.x, rgb.y, rgb.z);
}

}  // namespace

struct Pen::Canvas {
  cairo_surface_t* surface;
  cairo_t* cairo;

  Canvas(int width, int height)
      : surface(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height)),
        cairo(cairo_create(surface)) {}
  ~Canvas() {
    cairo_destroy(cairo);
    cairo_surface_destroy(surface);
  }
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
};

Pen::Pen(int width, int height, double em, bool light_below, int first_row)
    : em_(em),
      ink_(light_below ? Vec3d{0.07, 0.07, 0.07} : Vec3d{1, 1, 1}),
      rim_(light_below ? Vec3d{1, 1, 1} : Vec3d{0, 0, 0}),
      canvas_(std::make_unique<Canvas>(width, height)) {
  cairo_t* cairo = canvas_->cairo;
  cairo_translate(cairo, 0, -first_row);
  cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(cairo, CAIRO_LINE_JOIN_ROUND);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, em_);
  if (cairo_status(cairo) != CAIRO_STATUS_SUCCESS)
    failSystem("annotations cannot be drawn: {}", cairo_status_to_string(cairo_status(cairo)));
  if (!(widthOf("0") > 0))
    failSystem("annotations cannot be drawn: no font is installed; install fonts-dejavu-core");
}

Pen::~Pen() = default;

double Pen::widthOf(const std::string& text) const {
  cairo_text_extents_t extents{};
  cairo_text_extents(canvas_->cairo, text.c_str(), &extents);
  return extents.x_advance;
}

void Pen::word(Point at, Anchor anchor, const std::string& text, Vec3d rgb) {
  cairo_t* cairo = canvas_->cairo;
  // The middle of digits and capitals, the same for all words so that rows of them are even.
  cairo_text_extents_t digit{};
  cairo_text_extents(cairo, "0", &digit);
  const double share = anchor == Anchor::kLeft ? 0 : anchor == Anchor::kMiddle ? 0.5 : 1;
  cairo_move_to(cairo, at.x - share * widthOf(text), at.y + digit.height / 2);
  cairo_text_path(cairo, text.c_str());
  cairo_set_line_width(cairo, 2 * kRimWidth * em_);
  setColor(cairo, rim_);
  cairo_stroke_preserve(cairo);
  setColor(cairo, rgb);
  cairo_fill(cairo);
}

void Pen::line(const std::vector<Point>& through, double width, Vec3d rgb) {
  cairo_t* cairo = canvas_->cairo;
  width = std::max(width, 1.4);  // thinner ones are pale
  for (const Point& point : through) cairo_line_to(cairo, point.x, point.y);
  cairo_set_line_width(cairo, width + kRimWidth * em_);
  setColor(cairo, rim_);
  cairo_stroke_preserve(cairo);
  cairo_set_line_width(cairo, width);
  setColor(cairo, rgb);
  cairo_stroke(cairo);
}

void Pen::area(const std::vector<Point>& corners, Vec3d rgb) {
  cairo_t* cairo = canvas_->cairo;
  for (const Point& corner : corners) cairo_line_to(cairo, corner.x, corner.y);
  cairo_close_path(cairo);
  setColor(cairo, rgb);
  // Neighbouring areas meet without a seam.
  cairo_set_antialias(cairo, CAIRO_ANTIALIAS_NONE);
  cairo_fill(cairo);
  cairo_set_antialias(cairo, CAIRO_ANTIALIAS_DEFAULT);
}

Picture Pen::over(const Picture& picture) const {
  cairo_surface_flush(canvas_->surface);
  const unsigned char* rows = cairo_image_surface_get_data(canvas_->surface);
  const auto stride = static_cast<size_t>(cairo_image_surface_get_stride(canvas_->surface));
  SLUICE_CHECK_EQ(cairo_image_surface_get_width(canvas_->surface), picture.width);
  SLUICE_CHECK_EQ(cairo_image_surface_get_height(canvas_->surface), picture.height);
  Picture result = picture;
  const auto width = static_cast<size_t>(picture.width),
             height = static_cast<size_t>(picture.height);
  for (size_t y = 0; y < height; ++y)
    for (size_t x = 0; x < width; ++x) {
      // Premultiplied, in the machine's order: blue is the lowest byte.
      uint32_t pixel = 0;
      std::memcpy(&pixel, rows + y * stride + 4 * x, sizeof pixel);
      if (pixel == 0) continue;
      const auto channel = [&](int shift) {
        return static_cast<float>(pixel >> shift & 0xFFU) / 255;
      };
      float* const out = result.rgba.data() + 4 * (y * width + x);
      const float through = 1 - channel(24);
      out[0] = channel(16) + through * out[0];
      out[1] = channel(8) + through * out[1];
      out[2] = channel(0) + through * out[2];
      out[3] = channel(24) + through * out[3];
    }
  return result;
}

}  // namespace sluice

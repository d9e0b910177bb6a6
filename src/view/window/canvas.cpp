#include "src/view/window/canvas.h"

#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_opengl3.h>

#include <cmath>
#include <cstring>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

// take() copies the vertices as bytes.
static_assert(sizeof(DrawnVertex) == sizeof(ImDrawVert));

template <class Function>
Function load(const char* name) {
  const auto function = reinterpret_cast<Function>(glfwGetProcAddress(name));
  if (function == nullptr) failSystem("the window's OpenGL has no {}; 3.3 is needed", name);
  return function;
}

uint64_t numberOf(const void* texture) {
  return reinterpret_cast<uintptr_t>(texture);
}

void take(DrawnList& list, const ImDrawList& from, ImVec2 origin) {
  list.name = from._OwnerName != nullptr ? from._OwnerName : "";
  list.vertices.resize(static_cast<size_t>(from.VtxBuffer.Size));
  if (!list.vertices.empty())
    std::memcpy(static_cast<void*>(list.vertices.data()), from.VtxBuffer.Data,
                list.vertices.size() * sizeof(DrawnVertex));
  list.indices.assign(from.IdxBuffer.begin(), from.IdxBuffer.end());
  list.commands.clear();
  for (const ImDrawCmd& command : from.CmdBuffer) {
    const ImVec4& clip = command.ClipRect;
    list.commands.push_back(
        {{clip.x - origin.x, clip.y - origin.y, clip.z - origin.x, clip.w - origin.y},
         numberOf(command.GetTexID()),
         command.IdxOffset,
         command.ElemCount,
         command.VtxOffset});
  }
}

// The commands once for each area that they meet, cut to it, and upside down. Areas do not meet, so
// that nothing is blended twice.
void cut(ImDrawList& list, const std::vector<ScreenArea>& areas, float height) {
  ImVector<ImDrawCmd> commands;
  for (const ScreenArea& area : areas)
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ImVec4& clip = command.ClipRect;
      const ScreenArea met = common(area, {clip.x, clip.y, clip.z, clip.w});
      if (met.isEmpty() || command.ElemCount == 0) continue;
      commands.push_back(command);
      // OpenGL counts rows from the bottom, and the canvas from the top.
      commands.back().ClipRect = {met.left, height - met.bottom, met.right, height - met.top};
    }
  list.CmdBuffer.swap(commands);
  for (ImDrawVert& vertex : list.VtxBuffer) vertex.pos.y = height - vertex.pos.y;
}

ScreenArea areaOf(const Canvas::Backdrop& backdrop) {
  return {static_cast<float>(backdrop.left), static_cast<float>(backdrop.top),
          static_cast<float>(backdrop.left + backdrop.width),
          static_cast<float>(backdrop.top + backdrop.height)};
}

bool holds(const ScreenArea& outer, const ScreenArea& inner) {
  return hull(outer, inner) == outer;
}

}  // namespace

struct Canvas::Functions {
  PFNGLGENFRAMEBUFFERSPROC gen = load<PFNGLGENFRAMEBUFFERSPROC>("glGenFramebuffers");
  PFNGLDELETEFRAMEBUFFERSPROC remove = load<PFNGLDELETEFRAMEBUFFERSPROC>("glDeleteFramebuffers");
  PFNGLBINDFRAMEBUFFERPROC bind = load<PFNGLBINDFRAMEBUFFERPROC>("glBindFramebuffer");
  PFNGLFRAMEBUFFERTEXTURE2DPROC attach =
      load<PFNGLFRAMEBUFFERTEXTURE2DPROC>("glFramebufferTexture2D");
  PFNGLCHECKFRAMEBUFFERSTATUSPROC check =
      load<PFNGLCHECKFRAMEBUFFERSTATUSPROC>("glCheckFramebufferStatus");
  PFNGLBLITFRAMEBUFFERPROC blit = load<PFNGLBLITFRAMEBUFFERPROC>("glBlitFramebuffer");
};

Canvas::Canvas() : gl_(std::make_unique<const Functions>()) {
  gl_->gen(1, &framebuffer_);
}

Canvas::~Canvas() {
  gl_->remove(1, &framebuffer_);
  if (pixels_ != 0) glDeleteTextures(1, &pixels_);
}

void Canvas::resize(int width, int height) {
  // The canvas keeps its pixels from frame to frame, since only changed areas are drawn again.
  if (width == width_ && height == height_) return;
  if (pixels_ == 0) glGenTextures(1, &pixels_);
  glBindTexture(GL_TEXTURE_2D, pixels_);
  // Its bytes in the order that screens have: a copy then is one.
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_BGRA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl_->bind(GL_FRAMEBUFFER, framebuffer_);
  gl_->attach(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, pixels_, 0);
  const bool is_complete = gl_->check(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  // Software GL compiles its code for clearing an area when it is first used: do it now, not during
  // a drag.
  glEnable(GL_SCISSOR_TEST);
  glScissor(0, 0, 1, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glDisable(GL_SCISSOR_TEST);
  gl_->bind(GL_FRAMEBUFFER, 0);
  if (!is_complete) failSystem("the window's OpenGL cannot draw {} x {} pixels", width, height);
  width_ = width;
  height_ = height;
  is_new_ = true;
}

Canvas::Backdrop& Canvas::renewBackdrop() {
  // The place of the old backdrop has to be drawn again, too.
  backdrop_was_ = hull(backdrop_was_, areaOf(backdrop_));
  backdrop_is_new_ = true;
  return backdrop_;
}

void Canvas::dropBackdrop() {
  if (!backdrop_.bgra.empty()) renewBackdrop() = {};
}

void Canvas::noteRedrawn(const void* texture) {
  redrawn_.push_back(numberOf(texture));
}

const std::vector<ScreenArea>& Canvas::compare(const ImDrawData& data, int width, int height) {
  resize(width, height);
  now_.resize(static_cast<size_t>(data.CmdListsCount));
  for (int i = 0; i < data.CmdListsCount; ++i)
    take(now_[static_cast<size_t>(i)], *data.CmdLists[i], data.DisplayPos);
  const ScreenArea all{0, 0, data.DisplaySize.x, data.DisplaySize.y};
  const ImVec2 scale = data.FramebufferScale;
  // A new canvas has no pixels to keep.
  areas_ = is_new_ ? std::vector{all} : changedAreas(last_, now_, redrawn_, all);
  scale_x_ = scale.x;
  scale_y_ = scale.y;
  if (backdrop_is_new_) {
    const ScreenArea area = hull(backdrop_was_, areaOf(backdrop_));
    areas_.push_back(common(all, {area.left / scale.x, area.top / scale.y, area.right / scale.x,
                                  area.bottom / scale.y}));
  }
  // Whole pixels.
  for (ScreenArea& area : areas_)
    area = common(
        all,
        {std::floor(area.left * scale.x) / scale.x, std::floor(area.top * scale.y) / scale.y,
         std::ceil(area.right * scale.x) / scale.x, std::ceil(area.bottom * scale.y) / scale.y});
  // Areas that meet would blend what is translucent in them twice.
  areas_ = apart(std::move(areas_));
  return areas_;
}

void Canvas::drawBackdrop(const ScreenArea& area) {
  const ScreenArea shown = common(area, areaOf(backdrop_));
  if (shown.isEmpty() || backdrop_.bgra.empty()) return;
  const auto left = static_cast<int>(shown.left), top = static_cast<int>(shown.top);
  glBindTexture(GL_TEXTURE_2D, pixels_);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, backdrop_.width);
  const size_t first =
      static_cast<size_t>(top - backdrop_.top) * static_cast<size_t>(backdrop_.width) +
      static_cast<size_t>(left - backdrop_.left);
  glTexSubImage2D(GL_TEXTURE_2D, 0, left, top, static_cast<int>(shown.right) - left,
                  static_cast<int>(shown.bottom) - top, GL_BGRA, GL_UNSIGNED_BYTE,
                  &backdrop_.bgra[first]);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

void Canvas::draw(ImDrawData& data) {
  // The canvas is a framebuffer of our own: the contents of the window's are undefined after each
  // swap, so that nothing could be kept there.
  drawn_pixels_ = 0;
  const ScreenArea canvas{0, 0, static_cast<float>(width_), static_cast<float>(height_)};
  gl_->bind(GL_FRAMEBUFFER, framebuffer_);
  glEnable(GL_SCISSOR_TEST);
  glViewport(0, 0, width_, height_);
  glClearColor(0.09F, 0.09F, 0.1F, 1);
  for (const ScreenArea& area : areas_) {
    const ScreenArea at =
        common(canvas, {std::round(area.left * scale_x_), std::round(area.top * scale_y_),
                        std::round(area.right * scale_x_), std::round(area.bottom * scale_y_)});
    if (at.isEmpty()) continue;
    const auto left = static_cast<int>(at.left), top = static_cast<int>(at.top);
    const int wide = static_cast<int>(at.right) - left, high = static_cast<int>(at.bottom) - top;
    glScissor(left, top, wide, high);
    // An area that the backdrop fills need not be cleared first.
    if (backdrop_.bgra.empty() || !holds(areaOf(backdrop_), at)) glClear(GL_COLOR_BUFFER_BIT);
    drawBackdrop(at);
    drawn_pixels_ += static_cast<uint64_t>(wide) * static_cast<uint64_t>(high);
  }
  glDisable(GL_SCISSOR_TEST);
  for (int i = 0; i < data.CmdListsCount; ++i) cut(*data.CmdLists[i], areas_, data.DisplaySize.y);
  if (!areas_.empty()) ImGui_ImplOpenGL3_RenderDrawData(&data);
  gl_->bind(GL_DRAW_FRAMEBUFFER, 0);
  // The canvas is upside down, so the copy turns it.
  gl_->blit(0, 0, width_, height_, 0, height_, width_, 0, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_->bind(GL_FRAMEBUFFER, 0);
  // The lists change places instead of being copied, and keep their memory for the next frame.
  std::swap(last_, now_);
  redrawn_.clear();
  is_new_ = backdrop_is_new_ = false;
  backdrop_was_ = {};
}

}  // namespace sluice

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

static_assert(sizeof(DrawnVertex) == sizeof(ImDrawVert));

template <class Function>
Function load(const char* name) {
  const auto function = reinterpret_cast<Function>(glfwGetProcAddress(name));
  if (function == nullptr) fail("the window's OpenGL has no {}; 3.3 is needed", name);
  return function;
}

uint64_t numberOf(const void* texture) {
  return reinterpret_cast<uintptr_t>(texture);
}

void take(DrawnList& list, const ImDrawList& from, ImVec2 origin) {
  list.name = from._OwnerName != nullptr ? from._OwnerName : "";
  list.vertices.resize(static_cast<size_t>(from.VtxBuffer.Size));
  if (!list.vertices.empty())
    std::memcpy(list.vertices.data(), from.VtxBuffer.Data,
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

// The commands once for each area that they meet, cut to it. Areas do not meet, so that nothing is
// blended twice.
void cut(ImDrawList& list, const std::vector<ScreenArea>& areas) {
  ImVector<ImDrawCmd> commands;
  for (const ScreenArea& area : areas)
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ImVec4& clip = command.ClipRect;
      const ScreenArea met = common(area, {clip.x, clip.y, clip.z, clip.w});
      if (met.isEmpty() || command.ElemCount == 0) continue;
      commands.push_back(command);
      commands.back().ClipRect = {met.left, met.top, met.right, met.bottom};
    }
  list.CmdBuffer.swap(commands);
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
  gl_->bind(GL_FRAMEBUFFER, 0);
  if (!is_complete) fail("the window's OpenGL cannot draw {} x {} pixels", width, height);
  width_ = width;
  height_ = height;
  is_new_ = true;
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
  areas_ = is_new_ ? std::vector{all} : changedAreas(last_, now_, redrawn_, all);
  // Whole pixels.
  for (ScreenArea& area : areas_)
    area = common(
        all,
        {std::floor(area.left * scale.x) / scale.x, std::floor(area.top * scale.y) / scale.y,
         std::ceil(area.right * scale.x) / scale.x, std::ceil(area.bottom * scale.y) / scale.y});
  areas_ = apart(std::move(areas_));
  return areas_;
}

void Canvas::draw(ImDrawData& data) {
  drawn_pixels_ = 0;
  const ImVec2 scale = data.FramebufferScale;
  glEnable(GL_SCISSOR_TEST);
  gl_->bind(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, width_, height_);
  glClearColor(0.09F, 0.09F, 0.1F, 1);
  for (const ScreenArea& area : areas_) {
    const auto left = static_cast<int>(std::lround(area.left * scale.x));
    const auto bottom = static_cast<int>(std::lround(area.bottom * scale.y));
    const auto wide = static_cast<int>(std::lround(area.right * scale.x)) - left;
    const auto high = bottom - static_cast<int>(std::lround(area.top * scale.y));
    glScissor(left, height_ - bottom, wide, high);
    glClear(GL_COLOR_BUFFER_BIT);
    drawn_pixels_ += static_cast<uint64_t>(wide) * static_cast<uint64_t>(high);
  }
  if (!areas_.empty()) {
    for (int i = 0; i < data.CmdListsCount; ++i) cut(*data.CmdLists[i], areas_);
    ImGui_ImplOpenGL3_RenderDrawData(&data);
  }
  glDisable(GL_SCISSOR_TEST);
  gl_->bind(GL_DRAW_FRAMEBUFFER, 0);
  gl_->blit(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_->bind(GL_FRAMEBUFFER, 0);
  std::swap(last_, now_);
  redrawn_.clear();
  is_new_ = false;
}

}  // namespace sluice

#include "src/gl/screen_textures.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/gl/shaders/shader_text.h"

namespace sluice {
namespace {

constexpr const char* kOver = R"(#version 330 core
uniform sampler2D picture;
uniform vec3 background;
layout(location = 0) out vec4 shown;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  at.y = textureSize(picture, 0).y - 1 - at.y;
  vec4 color = texelFetch(picture, at, 0);
  shown = vec4(color.rgb + (1.0 - color.a) * background, 1.0);
}
)";

constexpr const char* kShown = R"(#version 330 core
uniform sampler2D picture;
uniform float least_opacity;
layout(location = 0) out vec4 shown;
void main() {
  if (texelFetch(picture, ivec2(gl_FragCoord.xy), 0).a < least_opacity) discard;
  shown = vec4(1.0);
}
)";

}  // namespace

ScreenTextures::~ScreenTextures() {
  for (Slot& slot : slots_) {
    // A reader that still holds the texture deletes it (Texture::letGo()). The flag decides if both
    // let go at once: with their counts of holders alone, each could leave it to the other.
    if (slot.seen.use_count() > 1 && !slot.is_let_go->exchange(true)) continue;
    gl_.DeleteSync(slot.drawn);
    gl_.DeleteSync(static_cast<GLsync>(slot.seen->load()));
    gl_.DeleteTextures(1, &slot.texture);
  }
  gl_.DeleteFramebuffers(1, &framebuffer_);
  gl_.DeleteQueries(1, &query_);
}

void ScreenTextures::makePrograms() {
  if (over_ != nullptr) return;
  over_ = std::make_unique<GlProgram>(gl_, kCoverText, kOver);
  shown_ = std::make_unique<GlProgram>(gl_, kCoverText, kShown);
  gl_.GenFramebuffers(1, &framebuffer_);
  gl_.GenQueries(1, &query_);
}

bool ScreenTextures::showsSomething() {
  shown_->use();
  shown_->set("picture", 0);
  shown_->set("least_opacity", kLeastOpacity);
  gl_.BeginQuery(GL_ANY_SAMPLES_PASSED, query_);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.EndQuery(GL_ANY_SAMPLES_PASSED);
  GLuint any = 0;
  gl_.GetQueryObjectuiv(query_, GL_QUERY_RESULT, &any);
  return any != 0;
}

ScreenTextures::Slot& ScreenTextures::freeSlot(PictureSize size) {
  auto slot = std::ranges::find_if(slots_, [](const Slot& s) { return s.seen.use_count() == 1; });
  if (slot == slots_.end()) {
    slot = slots_.emplace(slots_.end());
    slot->seen = std::make_shared<std::atomic<void*>>(nullptr);
    slot->is_let_go = std::make_shared<std::atomic<bool>>(false);
    gl_.GenTextures(1, &slot->texture);
  }
  if (slot->drawn != nullptr) gl_.DeleteSync(slot->drawn);
  slot->drawn = nullptr;
  *slot->is_let_go = false;  // by the last reader, which is gone
  // The window's last commands that read the texture come before what is drawn over it.
  if (const auto seen = static_cast<GLsync>(slot->seen->exchange(nullptr))) {
    gl_.WaitSync(seen, 0, GL_TIMEOUT_IGNORED);
    gl_.DeleteSync(seen);
  }
  gl_.BindTexture(GL_TEXTURE_2D, slot->texture);
  if (slot->size.width != size.width || slot->size.height != size.height) {
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, size.width, size.height, 0, GL_RGBA,
                   GL_UNSIGNED_BYTE, nullptr);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    slot->size = size;
  }
  return *slot;
}

ScreenPicture ScreenTextures::make(GLuint picture, PictureSize size,
                                   std::array<float, 3> background) {
  makePrograms();
  gl_.ActiveTexture(GL_TEXTURE0);
  Slot& slot = freeSlot(size);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, slot.texture, 0);
  if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    failSystem("the GL driver cannot draw a screen's picture of {} x {} pixels", size.width,
               size.height);
  gl_.Viewport(0, 0, size.width, size.height);
  for (const GLenum off : {GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST, GL_SCISSOR_TEST})
    gl_.Disable(off);
  gl_.BindTexture(GL_TEXTURE_2D, picture);
  // Its pixels are drawn over below.
  const bool shows_something = showsSomething();
  over_->use();
  over_->set("picture", 0);
  over_->set("background", Vec3d{background[0], background[1], background[2]});
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  slot.drawn = gl_.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl_.Flush();  // else a thread that waits for the fence may wait for ever
  return {slot.texture, size.width,     size.height,    slot.drawn,
          slot.seen,    slot.is_let_go, shows_something};
}

}  // namespace sluice

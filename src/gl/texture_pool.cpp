#include "src/gl/texture_pool.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {

struct GlFormat {
  GLint internal;
  GLenum type, numbers;
};
GlFormat glFormat(TexturePool::Format format) {
  const bool two = format.has_spread;
  const GLenum numbers = two ? GL_RG : GL_RED;
  switch (format.type) {
    case DeviceType::kU8:
      return {two ? GL_RG8 : GL_R8, GL_UNSIGNED_BYTE, numbers};
    case DeviceType::kU16:
      return {two ? GL_RG16 : GL_R16, GL_UNSIGNED_SHORT, numbers};
    case DeviceType::kF32:
      break;
  }
  return {two ? GL_RG32F : GL_R32F, GL_FLOAT, numbers};
}

uint64_t bytesOf(Vec3i size_vox, TexturePool::Format format) {
  return static_cast<uint64_t>(volume(size_vox)) * bytesPerVoxel(format.type) *
         (format.has_spread ? 2 : 1);
}

}  // namespace

TexturePool::~TexturePool() {
  for (auto& [size, textures] : idle_)
    for (const GLuint texture : textures) gl_.DeleteTextures(1, &texture);
}

GLuint TexturePool::create(Vec3i size_vox, Format format) {
  GLuint texture = 0;
  gl_.GenTextures(1, &texture);
  gl_.BindTexture(GL_TEXTURE_3D, texture);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    gl_.TexParameteri(GL_TEXTURE_3D, wrap, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAX_LEVEL, 0);
  const auto [internal, type, numbers] = glFormat(format);
  while (gl_.GetError() != GL_NO_ERROR) {
  }
  gl_.TexImage3D(GL_TEXTURE_3D, 0, internal, static_cast<GLsizei>(size_vox.x),
                 static_cast<GLsizei>(size_vox.y), static_cast<GLsizei>(size_vox.z), 0, numbers,
                 type, nullptr);
  if (gl_.GetError() != GL_NO_ERROR) {
    gl_.DeleteTextures(1, &texture);
    failSystem(
        "the GL driver has no room for a texture of {} x {} x {} texels ({}); give fewer --pages",
        size_vox.x, size_vox.y, size_vox.z, formatBytes(bytesOf(size_vox, format)));
  }
  return texture;
}

void TexturePool::dropIdle(uint64_t bytes) {
  // A texture keeps its memory while a queued draw reads it: deleted sooner, the old ones and those
  // that replace them would be there at once.
  gl_.Finish();
  for (auto entry = idle_.begin(); entry != idle_.end() && bytes > 0;) {
    auto& [size, textures] = *entry;
    const uint64_t each = bytesOf({size.x, size.y, size.z}, size.format);
    while (!textures.empty() && bytes > 0) {
      gl_.DeleteTextures(1, &textures.front());
      textures.pop_front();
      idle_bytes_ -= each;
      bytes -= std::min(bytes, each);
    }
    entry = textures.empty() ? idle_.erase(entry) : std::next(entry);
  }
}

GLuint TexturePool::take(Vec3i size_vox, Format format, std::span<const std::byte> texels) {
  const uint64_t bytes = bytesOf(size_vox, format);
  SLUICE_CHECK_EQ(texels.size(), bytes);
  const uint64_t used_bytes = used_bytes_ + bytes;
  const uint64_t most_used_bytes = std::max(most_used_bytes_, used_bytes);
  GLuint texture = 0;
  const auto found = idle_.find({size_vox.x, size_vox.y, size_vox.z, format});
  if (found != idle_.end()) {
    texture = found->second.front();
    found->second.pop_front();
    if (found->second.empty()) idle_.erase(found);
    idle_bytes_ -= bytes;
    gl_.BindTexture(GL_TEXTURE_3D, texture);
  } else {
    const uint64_t most = most_used_bytes + spareTextureBytes(most_used_bytes);
    if (used_bytes + idle_bytes_ > most) dropIdle(used_bytes + idle_bytes_ - most);
    texture = create(size_vox, format);
  }
  used_bytes_ = used_bytes;
  most_used_bytes_ = most_used_bytes;
  const auto [internal, type, numbers] = glFormat(format);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, static_cast<GLsizei>(size_vox.x),
                    static_cast<GLsizei>(size_vox.y), static_cast<GLsizei>(size_vox.z), numbers,
                    type, texels.data());
  uploaded_bytes_ += texels.size();
  return texture;
}

void TexturePool::giveBack(GLuint texture, Vec3i size_vox, Format format) {
  const uint64_t bytes = bytesOf(size_vox, format);
  used_bytes_ -= bytes;
  idle_bytes_ += bytes;
  idle_[{size_vox.x, size_vox.y, size_vox.z, format}].push_back(texture);
}

}  // namespace sluice

// Textures are reused by size, hold the data uploaded last, and do not pile up.
#include "src/gl/texture_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "src/base/error.h"
#include "src/gl/contexts/context.h"

namespace sluice {
namespace {

std::vector<std::byte> bytesOf(size_t count, int value) {
  return std::vector<std::byte>(count, static_cast<std::byte>(value));
}

class TexturePoolTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    try {
      context_ = createContext(GlChoice::kOsmesa);
    } catch (const Error&) {
      context_ = createContext(GlChoice::kEgl);
    }
  }
  static void TearDownTestSuite() { context_.reset(); }
  static const GlFunctions& gl() { return context_->functions(); }

  // All texels as they lie in the texture.
  template <class T>
  static std::vector<T> texelsOf(GLuint texture, size_t count, GLenum type) {
    std::vector<T> texels(count);
    gl().BindTexture(GL_TEXTURE_3D, texture);
    gl().PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl().GetTexImage(GL_TEXTURE_3D, 0, GL_RED, type, texels.data());
    return texels;
  }
  // Binding the name of a deleted texture is an error of the core profile.
  static bool exists(GLuint texture) {
    while (gl().GetError() != GL_NO_ERROR) {
    }
    gl().BindTexture(GL_TEXTURE_3D, texture);
    return gl().GetError() == GL_NO_ERROR;
  }

 private:
  static inline std::unique_ptr<GlContext> context_;
};

TEST_F(TexturePoolTest, texturesHoldWhatWasUploaded) {
  TexturePool pool(gl());
  // Odd sizes: rows are not padded to four bytes.
  std::vector<std::byte> ramp(3 * 5 * 7);
  for (size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<std::byte>(i * 2);
  const GLuint u8 = pool.take({3, 5, 7}, {DeviceType::kU8}, ramp);
  const auto bytes = texelsOf<uint8_t>(u8, ramp.size(), GL_UNSIGNED_BYTE);
  EXPECT_EQ(std::memcmp(bytes.data(), ramp.data(), ramp.size()), 0);

  const std::vector<uint16_t> words = {0, 1, 2, 32767, 32768, 65534, 65535, 300};
  const GLuint u16 = pool.take({2, 2, 2}, {DeviceType::kU16}, std::as_bytes(std::span(words)));
  EXPECT_EQ(texelsOf<uint16_t>(u16, 8, GL_UNSIGNED_SHORT), words);

  const std::vector<float> floats = {-1e30F, -2.5F, 0, 1e-20F, 1, 255, 1e20F, 1e30F};
  const GLuint f32 = pool.take({2, 2, 2}, {DeviceType::kF32}, std::as_bytes(std::span(floats)));
  EXPECT_EQ(texelsOf<float>(f32, 8, GL_FLOAT), floats);
  EXPECT_EQ(pool.uploadedBytes(), 105U + 16 + 32);
  pool.giveBack(u8, {3, 5, 7}, {DeviceType::kU8});
  pool.giveBack(u16, {2, 2, 2}, {DeviceType::kU16});
  pool.giveBack(f32, {2, 2, 2}, {DeviceType::kF32});
}

TEST_F(TexturePoolTest, returnedTextureServesTheNextChunkOfItsSizeAndType) {
  TexturePool pool(gl());
  const GLuint first = pool.take({4, 4, 4}, {DeviceType::kU8}, bytesOf(64, 1));
  const GLuint second = pool.take({4, 4, 4}, {DeviceType::kU8}, bytesOf(64, 2));
  EXPECT_NE(first, second) << "both are in use";
  pool.giveBack(first, {4, 4, 4}, {DeviceType::kU8});
  const GLuint wider = pool.take({8, 4, 2}, {DeviceType::kU8}, bytesOf(64, 3));
  const GLuint words = pool.take({4, 4, 4}, {DeviceType::kU16}, bytesOf(128, 3));
  EXPECT_NE(wider, first);
  EXPECT_NE(words, first);
  pool.giveBack(second, {4, 4, 4}, {DeviceType::kU8});
  const GLuint again = pool.take({4, 4, 4}, {DeviceType::kU8}, bytesOf(64, 4));
  EXPECT_TRUE(again == first || again == second);
  EXPECT_EQ(texelsOf<uint8_t>(again, 64, GL_UNSIGNED_BYTE), std::vector<uint8_t>(64, 4));
  EXPECT_EQ(pool.uploadedBytes(), 64U * 4 + 128);
  for (const GLuint texture : {again}) pool.giveBack(texture, {4, 4, 4}, {DeviceType::kU8});
  pool.giveBack(wider, {8, 4, 2}, {DeviceType::kU8});
  pool.giveBack(words, {4, 4, 4}, {DeviceType::kU16});
}

TEST_F(TexturePoolTest, idleTexturesOfOtherSizesGoForNewOnes) {
  TexturePool pool(gl());
  constexpr Vec3i kSmall{64, 64, 256}, kLarge{128, 64, 512};  // 1 and 4 MiB
  constexpr size_t kSmallBytes = 1 << 20, kLargeBytes = 4 << 20;
  constexpr size_t kCount = 32;
  const auto small_texels = bytesOf(kSmallBytes, 1), large_texels = bytesOf(kLargeBytes, 2);
  std::vector<GLuint> small, large;
  for (size_t i = 0; i < kCount; ++i)
    small.push_back(pool.take(kSmall, {DeviceType::kU8}, small_texels));
  for (const GLuint texture : small) pool.giveBack(texture, kSmall, {DeviceType::kU8});
  for (size_t i = 0; i < kCount / 4; ++i)
    large.push_back(pool.take(kLarge, {DeviceType::kU8}, large_texels));
  size_t left = 0;
  // Drivers may give the name of a deleted texture to a new one.
  for (const GLuint texture : small)
    left += exists(texture) && std::ranges::count(large, texture) == 0 ? 1 : 0;
  // Both kinds together take more bytes than were ever in use at once.
  EXPECT_LE(left * kSmallBytes, spareTextureBytes(kCount * kSmallBytes));
  for (const GLuint texture : large) pool.giveBack(texture, kLarge, {DeviceType::kU8});
}

TEST_F(TexturePoolTest, poolDeletesItsIdleTextures) {
  GLuint texture = 0;
  {
    TexturePool pool(gl());
    texture = pool.take({4, 4, 4}, {DeviceType::kU8}, bytesOf(64, 1));
    pool.giveBack(texture, {4, 4, 4}, {DeviceType::kU8});
    EXPECT_TRUE(exists(texture));
  }
  EXPECT_FALSE(exists(texture));
}

TEST_F(TexturePoolTest, refusedTextureIsAnErrorAndCostsNothing) {
  TexturePool pool(gl());
  // Longer than any driver's limit; the upload would be small.
  constexpr Vec3i kTooLong{1 << 20, 1, 1};
  EXPECT_THROW(pool.take(kTooLong, {DeviceType::kU8}, bytesOf(1 << 20, 1)), Error);
  EXPECT_EQ(pool.uploadedBytes(), 0U);
  const GLuint texture = pool.take({4, 4, 4}, {DeviceType::kU8}, bytesOf(64, 1));
  EXPECT_EQ(pool.uploadedBytes(), 64U);
  pool.giveBack(texture, {4, 4, 4}, {DeviceType::kU8});
}

}  // namespace
}  // namespace sluice

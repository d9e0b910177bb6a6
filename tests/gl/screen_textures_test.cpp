// Textures for a screen: of the device and the reader, the one that lets go last deletes them.
#include "src/gl/screen_textures.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "src/base/error.h"
#include "src/gl/contexts/context.h"

namespace sluice {
namespace {

class ScreenTexturesTest : public testing::Test {
 protected:
  void SetUp() override {
    try {
      context_ = createContext(GlChoice::kOsmesa);
    } catch (const Error&) {
      context_ = createContext(GlChoice::kEgl);
    }
    gl_ = context_->functions();
    delete_textures_ = gl_.DeleteTextures;
    gl_.DeleteTextures = [](GLsizei count, const GLuint* names) {
      deleted_ += count;
      delete_textures_(count, names);
    };
    deleted_ = 0;
    const std::vector<float> pixels(size_t{8} * 8 * 4, 0.5F);
    gl_.GenTextures(1, &picture_);
    gl_.BindTexture(GL_TEXTURE_2D, picture_);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 8, 8, 0, GL_RGBA, GL_FLOAT, pixels.data());
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    GLuint vertices = 0;
    gl_.GenVertexArrays(1, &vertices);
    gl_.BindVertexArray(vertices);
    textures_.emplace(gl_);
  }
  ScreenPicture make() { return textures_->make(picture_, {8, 8}, {0, 0, 0}); }

  static int deleted() { return deleted_; }

 private:
  static inline int deleted_ = 0;
  static inline PFNGLDELETETEXTURESPROC delete_textures_ = nullptr;

 protected:
  std::unique_ptr<GlContext> context_;
  GlFunctions gl_;
  GLuint picture_ = 0;
  std::optional<ScreenTextures> textures_;
};

TEST_F(ScreenTexturesTest, theDeviceDeletesWhatNobodyHolds) {
  make();
  textures_.reset();
  EXPECT_EQ(deleted(), 1);
}

TEST_F(ScreenTexturesTest, theReaderDeletesWhatItHoldsLonger) {
  const ScreenPicture held = make();
  textures_.reset();
  EXPECT_EQ(deleted(), 0);
  EXPECT_TRUE(held.is_let_go->exchange(true)) << "the reader learns that it is the last";
}

// The reader has set the flag and still has its share of the count.
TEST_F(ScreenTexturesTest, theDeviceDeletesIfTheReaderIsAboutToGo) {
  const ScreenPicture held = make();
  EXPECT_FALSE(held.is_let_go->exchange(true)) << "the reader leaves the texture to the device";
  textures_.reset();
  EXPECT_EQ(deleted(), 1);
}

TEST_F(ScreenTexturesTest, aTextureThatIsUsedAgainIsHeldAgain) {
  make().is_let_go->store(true);
  const ScreenPicture again = make();
  EXPECT_FALSE(again.is_let_go->load());
  textures_.reset();
  EXPECT_EQ(deleted(), 0);
}

}  // namespace
}  // namespace sluice

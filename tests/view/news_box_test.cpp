#include "src/view/drawing/news_box.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>

namespace sluice {
namespace {

// The renderer deletes the texture of such a picture at its end only if nobody else holds it.
TEST(NewsBox, letsGoOfAPictureThatNobodyHasTaken) {
  NewsBox box({});
  const auto seen = std::make_shared<std::atomic<void*>>(nullptr);
  box.add([&](News& news) {
    news.picture = std::make_unique<ShownPicture>();
    news.picture->screen = ScreenImage{};
    news.picture->screen->seen = seen;
    news.notes.emplace_back("a note");
  });
  EXPECT_EQ(seen.use_count(), 2);
  box.dropPicture();
  EXPECT_EQ(seen.use_count(), 1);
  EXPECT_EQ(box.take().notes.size(), 1);
}

}  // namespace
}  // namespace sluice

// NewsBox: the drawing thread's news, until somebody takes it. Any thread.
#pragma once

#include <functional>
#include <utility>

#include "src/base/threads/mutex.h"
#include "src/view/drawing/desk.h"

namespace sluice {

class NewsBox {
 public:
  // `on_news` is called by the thread that adds news; it must return at once. Empty: nobody is
  // told.
  explicit NewsBox(std::function<void()> on_news) : on_news_(std::move(on_news)) {}

  // Returns after earlier calls of the old function have returned.
  void tellTo(std::function<void()> on_news) {
    const MutexLock lock(telling_);
    on_news_ = std::move(on_news);
  }
  // `change` gets the news, under the lock.
  template <class Change>
  void add(const Change& change) {
    {
      const MutexLock lock(mutex_);
      change(news_);
    }
    const MutexLock lock(telling_);
    if (on_news_) on_news_();
  }
  // Lets go of a picture that nobody has taken. To be called before its renderer ends, which
  // deletes the picture's texture only while nobody else holds it.
  void dropPicture() {
    const MutexLock lock(mutex_);
    news_.picture.reset();
  }
  News take() {
    const MutexLock lock(mutex_);
    return std::exchange(news_, {});
  }

 private:
  Mutex telling_;  // held during a call, so that tellTo() returns after the last call
  std::function<void()> on_news_ SLUICE_GUARDED_BY(telling_);
  Mutex mutex_;
  News news_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice

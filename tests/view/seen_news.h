// What tests of the drawing thread share: its options, and the news that a window would keep.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/view/drawing/drawing_thread.h"

namespace sluice {

inline constexpr const char* kVolume = "synth:shells,dims=40x36x32";
inline constexpr const char* kSeries = "synth:mixing,dims=24x24x24,steps=4";

inline DrawingOptions drawingOptions() {
  DrawingOptions made;
  made.renderer.device = RendererOptions::Device::kCpu;
  made.renderer.threads = 2;
  made.renderer.memory_bytes = uint64_t{64} << 20;
  return made;
}

// The news that a window keeps.
struct Seen {
  explicit Seen(Desk& from) : desk(from) {}

  template <class Until>
  bool until(const Until& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < end) {
      const bool is_done = done();  // news come before the status that tells of them
      News news = desk.take();
      if (news.opened) opened = std::move(news.opened);
      if (news.picture) {
        EXPECT_EQ(news.picture->rgba.size(), static_cast<size_t>(news.picture->width) *
                                                 static_cast<size_t>(news.picture->height) * 4);
        picture = std::move(news.picture);
      }
      if (news.look) look = std::move(news.look);
      if (news.state) state = std::move(news.state);
      if (news.placed) placed = news.placed;
      if (news.path) film = std::move(news.path);
      if (news.report) report = std::move(news.report);
      if (news.probe) probe = news.probe;
      for (ShownSlice& slice : news.slices) slices.push_back(std::move(slice));
      for (SavedNews& each : news.saved) saved.push_back(std::move(each));
      for (std::string& line : news.notes) notes.push_back(std::move(line));
      for (std::string& line : news.failures) failures.push_back(std::move(line));
      if (is_done) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  bool open(const std::string& path, const std::string& over = "") {
    opened.reset();
    failures.clear();
    ViewedVolume volume;
    volume.paths = {path};
    volume.options.over = over;
    desk.open(volume, std::nullopt);
    return until([&] { return opened != nullptr || !failures.empty(); }) && opened != nullptr;
  }
  Wish wish(int width = 96, int height = 80) const {
    Wish made;
    made.state = opened->state;
    made.width = width;
    made.height = height;
    return made;
  }
  bool whole(uint64_t number) {
    return until([&] { return desk.status().completed >= number; });
  }

  Desk& desk;
  std::unique_ptr<OpenedVolumeNews> opened;
  std::unique_ptr<ShownPicture> picture;
  std::unique_ptr<ShownLook> look;
  std::unique_ptr<ViewState> state;
  std::optional<ViewPath> film;
  std::unique_ptr<RenderReport> report;
  std::optional<PlacedNews> placed;
  std::optional<ProbeNews> probe;
  std::vector<ShownSlice> slices;
  std::vector<SavedNews> saved;
  std::vector<std::string> failures, notes;
};

}  // namespace sluice

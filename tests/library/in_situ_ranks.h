// Ranks of one process that draw a volume which they share in memory, for tests of in_situ.h.
#pragma once

#include <sluice/in_situ.h>
#include <sluice/renderer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/base/values/vec.h"
#include "src/library/in_situ.h"
#include "src/parallel/communication/in_process.h"

namespace sluice {

// A volume in one array, of shells with a texture, so that any step between boxes would be seen.
struct Field {
  std::array<int64_t, 3> dims;
  std::vector<uint16_t> voxels;

  explicit Field(std::array<int64_t, 3> size) : dims(size) {
    for (int64_t z = 0; z < dims[2]; ++z)
      for (int64_t y = 0; y < dims[1]; ++y)
        for (int64_t x = 0; x < dims[0]; ++x) {
          const double r = std::hypot(x - 0.5 * dims[0], y - 0.4 * dims[1], z - 0.5 * dims[2]);
          const double v =
              2000 + 1500 * std::sin(r / 3) + 400 * std::sin(0.9 * x) * std::cos(1.1 * y);
          voxels.push_back(static_cast<uint16_t>(v));
        }
  }
  ArrayLayout layout() const { return {.dims = dims, .type = "u16", .spacing = {1, 1.2, 0.8}}; }
  Vec3i size() const { return {dims[0], dims[1], dims[2]}; }
};

// A rank of a simulation has its box with ghosts, as far as the volume reaches.
struct Part {
  LentBox box;
  std::vector<uint16_t> voxels;

  Part(const Field& field, const Box3& own, int64_t below, int64_t above) {
    const Vec3i ghosts_below{below, below, below}, ghosts_above{above, above, above};
    const Box3 there =
        unite(own, intersect({own.lo - ghosts_below, own.hi + ghosts_above}, boxOf(field.size())));
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<size_t>(a);
      box.lo[i] = own.lo[a];
      box.hi[i] = own.hi[a];
      box.ghosts_below[i] = own.lo[a] - there.lo[a];
      box.ghosts_above[i] = there.hi[a] - own.hi[a];
    }
    if (!boxOf(field.size()).contains(own)) return;  // refused before a voxel is read
    for (int64_t z = there.lo.z; z < there.hi.z; ++z)
      for (int64_t y = there.lo.y; y < there.hi.y; ++y)
        for (int64_t x = there.lo.x; x < there.hi.x; ++x)
          voxels.push_back(
              field.voxels[static_cast<size_t>((z * field.dims[1] + y) * field.dims[0] + x)]);
  }
};

// Cuts the longest side of the largest box again and again, at odd places.
inline std::vector<Box3> bisected(Vec3i dims, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Box3> boxes{boxOf(dims)};
  while (static_cast<int>(boxes.size()) < count) {
    const auto largest =
        std::max_element(boxes.begin(), boxes.end(),
                         [](const Box3& a, const Box3& b) { return a.count() < b.count(); });
    Box3 below = *largest, above = *largest;
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (below.size()[a] > below.size()[axis]) axis = a;
    const int64_t side = below.size()[axis];
    const int64_t at = below.lo[axis] + side / 2 + static_cast<int64_t>(random() % 7) - 3;
    below.hi[axis] = above.lo[axis] = at;
    *largest = below;
    boxes.push_back(above);
  }
  std::shuffle(boxes.begin(), boxes.end(), random);  // no rank is near its neighbours
  return boxes;
}

inline PictureOptions pictureFrom(double azimuth, bool perspective) {
  PictureOptions picture;
  picture.width = 120;
  picture.height = 100;
  picture.view.fit = ViewOptions::Fit::kVolume;  // as ranks do
  picture.view.azimuth_deg = azimuth;
  picture.view.elevation_deg = 25;
  picture.view.projection =
      perspective ? ViewOptions::Projection::kPerspective : ViewOptions::Projection::kParallel;
  return picture;
}

struct Drawn {
  std::vector<Image> images;  // rank 0's
  std::vector<std::string> failures;
  uint64_t most_peak_bytes = 0;  // of levels 2 to 3, of any rank
};

inline RendererOptions onCpu(uint64_t memory_bytes = uint64_t{64} << 20) {
  RendererOptions options;
  options.device = RendererOptions::Device::kCpu;
  options.memory_bytes = memory_bytes;
  options.threads = 1;
  return options;
}

inline Drawn drawInSitu(const Field& field, const std::vector<Box3>& boxes, const LookOptions& look,
                        const std::vector<PictureOptions>& pictures, int64_t below = 1,
                        int64_t above = 2, const RendererOptions& machine = onCpu()) {
  Drawn drawn;
  std::vector<std::unique_ptr<Communicator>> ranks = inProcessRanks(static_cast<int>(boxes.size()));
  std::vector<std::thread> threads;
  drawn.failures.resize(boxes.size());
  Mutex mutex;
  for (size_t rank = 0; rank < boxes.size(); ++rank)
    threads.emplace_back([&, rank] {
      try {
        const Part part(field, boxes[rank], below, above);
        const Ranks all = ranksOf(std::move(ranks[rank]));
        EXPECT_EQ(all.rank(), static_cast<int>(rank));
        const Volume volume = Volume::borrow(part.voxels.data(), field.layout(), part.box, all, {},
                                             {.memory_bytes = uint64_t{64} << 20, .threads = 1});
        Renderer renderer(volume, look, machine);
        for (const PictureOptions& picture : pictures) {
          Image image = renderer.draw(picture);
          const RenderReport report = renderer.report();
          const MutexLock lock(mutex);
          drawn.most_peak_bytes =
              std::max(drawn.most_peak_bytes,
                       report.volume_buffer.peak_bytes + report.texture_buffer.peak_bytes);
          if (rank == 0)
            drawn.images.push_back(std::move(image));
          else
            EXPECT_TRUE(image.rgba.empty());
        }
      } catch (const std::exception& error) {
        drawn.failures[rank] = error.what();
      }
    });
  for (std::thread& thread : threads) thread.join();
  return drawn;
}

inline double largestDifference(const Image& a, const Image& b) {
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  double most = 0;
  for (size_t i = 0; i < std::min(a.rgba.size(), b.rgba.size()); ++i)
    most = std::max(most, std::abs(double{a.rgba[i]} - double{b.rgba[i]}));
  return most;
}

}  // namespace sluice

#include "tests/render/render_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "src/device/pictures/blue_noise.h"
#include "src/render/camera/index_space.h"
#include "tests/device/suite_device.h"

namespace sluice {
namespace {

FloatPicture fromDevice(Picture picture) {
  FloatPicture result;
  result.width = picture.width;
  result.height = picture.height;
  result.rgba = std::move(picture.rgba);
  result.depth = std::move(picture.depth);
  return result;
}

ReferenceMode referenceMode(Mode mode) {
  switch (mode) {
    case Mode::kMip:
      return ReferenceMode::kMaximum;
    case Mode::kMinip:
      return ReferenceMode::kMinimum;
    case Mode::kAverage:
      return ReferenceMode::kAverage;
    case Mode::kAttenuatedMip:
      return ReferenceMode::kAttenuatedMaximum;
    case Mode::kDepthMip:
      return ReferenceMode::kMaximumByDepth;
    case Mode::kComposite:
      break;
  }
  return ReferenceMode::kComposite;
}

std::shared_ptr<const SliceRanges> rangesOf(VolumeSource& source, const SceneOptions& options,
                                            WorkerPool& pool) {
  const BlockLayout layout =
      blockLayout(source.layout().dims, options.block_vox, options.lit || options.ghost ? 1 : 0);
  ProgressMeter progress;
  return std::make_shared<const SliceRanges>(
      buildSliceRanges(source, options.time, layout, {pool, progress}));
}

// The rounding of single precision. Steps: the renderer makes ramps of them, see OpacityTable. Ends
// of the visible values: the same and the part of a sample there, see LookUp. Faces: of coordinates
// of some hundred voxels.
Rounding roundingOf(const OpacityTable& table, const ValueMap& map) {
  const ValueRange range = table.deviceRange();
  const double entry =
      std::abs(map.scale) * (range.hi - range.lo) / std::max(1, table.entries() - 1);
  return {.step_value = (table.stepEntries() + 1) * entry,
          .end_value = (table.stepEntries() + 4) * entry,
          .face_vox = 1e-4,
          .label_weight = 1e-3,
          .place_steps = 1};
}

float doubtOf(const FloatPicture& a, const FloatPicture& b, size_t pixel) {
  return std::max(a.doubt.empty() ? 0 : a.doubt[pixel], b.doubt.empty() ? 0 : b.doubt[pixel]);
}

// A pixel in 100, where rounding decides. Half a per cent of the rays that cross a step have a
// sample on it, so more means that the pictures show different things.
int mostExcused(const FloatPicture& picture) {
  return std::max(1, picture.width * picture.height / 100);
}

}  // namespace

RenderScene::RenderScene(Device& device, VolumeSource& source, TransferFunction transfer,
                         const SceneOptions& options)
    : device_(device),
      source_(source),
      options_(options),
      transfer_(std::move(transfer)),
      pool_(options.threads),
      ranges_(rangesOf(source, options, pool_)),
      session_(sessionOver(source)) {}

std::unique_ptr<Session> RenderScene::sessionOver(VolumeSource& source) {
  SessionOptions options;
  options.page = {options_.page_vox, static_cast<int64_t>(bytesPerVoxel(ranges_->map.type)),
                  options_.pages};
  options.memory_bytes = options_.memory_bytes;
  options.policy = options_.policy;
  options.lit = options_.lit;
  options.partition = options_.partition;
  auto session =
      std::make_unique<Session>(TimeStep{&source, options_.time, ranges_}, device_, pool_, options);
  session->setTransferFunction(transfer_);
  return session;
}

Frame RenderScene::frame(const FrameOptions& options) {
  session_->setOptions(options);
  Frame frame = session_->frame();
  EXPECT_EQ(session_->volumeBufferCounters().brokenIdentity(), "");
  EXPECT_EQ(session_->textureBufferCounters().brokenIdentity(), "");
  EXPECT_EQ(session_->textureCache().counters().brokenIdentity(), "");
  return frame;
}

FloatPicture RenderScene::draw(const FrameOptions& options) {
  return fromDevice(frame(options).picture);
}

FloatPicture RenderScene::reference(const FrameOptions& options) const {
  ReferenceScene scene;
  scene.transfer = transfer_;
  scene.mode = referenceMode(options.mode);
  scene.time = options_.time;
  scene.crop = options.crop;
  for (const WorldPlane& plane : options.clip_planes)
    scene.clip_planes.push_back({plane.normal, plane.offset});
  if (options_.lit) scene.lighting = options.lighting;
  scene.value_range = valueRangeOf(source_, options_.time);
  scene.integrates = options.integrates;
  scene.attenuation = transfer_.attenuation;
  scene.depth_cueing = options.depth_cueing;
  if (options.shown_points != nullptr) scene.shown_points = *options.shown_points;
  scene.jitter = options.jitter;
  scene.jitterOf = [height = options.size.height](int i, int j) {
    const int y = height - 1 - j;  // rows of the mask go upwards
    return double{
        blueNoise()[static_cast<size_t>(y % kBlueNoiseSide * kBlueNoiseSide + i % kBlueNoiseSide)]};
  };
  scene.opacity_threshold = rayThreshold(options);
  scene.rounding = roundingOf({transfer_, ranges_->map, ranges_->device_range}, ranges_->map);
  return renderReference(source_, resolve(options, source_.layout()), scene);
}

void RenderScene::setTransfer(TransferFunction transfer) {
  transfer_ = std::move(transfer);
  session_->setTransferFunction(transfer_);
}

ValueRange valueRangeOf(VolumeSource& source, int64_t time) {
  const VolumeLayout& layout = source.layout();
  std::vector<std::byte> bytes(static_cast<size_t>(volume(layout.dims)) *
                               bytesPerVoxel(layout.type));
  source.readRegion(time, boxOf(layout.dims), bytes);
  ValueRange range{std::numeric_limits<double>::infinity(),
                   -std::numeric_limits<double>::infinity()};
  visitVoxelType(layout.type, [&](auto tag) {
    const auto* voxels = reinterpret_cast<const decltype(tag)*>(bytes.data());
    for (int64_t i = 0; i < volume(layout.dims); ++i) {
      const double value =
          static_cast<double>(voxels[i]) * layout.value_scale + layout.value_offset;
      if (!std::isfinite(value)) continue;
      range = {std::min(range.lo, value), std::max(range.hi, value)};
    }
  });
  return range;
}

testing::AssertionResult within(double tolerance_255, const FloatPicture& a,
                                const FloatPicture& b) {
  const Difference d = compare(a, b, tolerance_255);
  if (d.max_255 <= tolerance_255) return testing::AssertionSuccess();
  // Pixels may differ where the reference finds that rounding decides, by as much as it says.
  int excused = 0;
  for (size_t pixel = 0; pixel < a.rgba.size() / 4; ++pixel) {
    const double difference = difference255(a.rgba, b.rgba, pixel);
    if (difference <= tolerance_255) continue;
    const double doubt_255 = 255.0 * static_cast<double>(doubtOf(a, b, pixel));
    if (difference <= tolerance_255 + doubt_255) {
      ++excused;
      continue;
    }
    const int x = static_cast<int>(pixel) % a.width, y = static_cast<int>(pixel) / a.width;
    const auto p = a.at(x, y), q = b.at(x, y);
    return testing::AssertionFailure() << fmt::format(
               "{:.3f}/255 at ({}, {}) of {} x {} where rounding explains {:.3f}; mean {:.5f}, {} "
               "pixels over {}: {:.5f} {:.5f} {:.5f} {:.5f} against {:.5f} {:.5f} {:.5f} {:.5f}",
               difference, x, y, a.width, a.height, doubt_255, d.mean_255, d.pixels_over,
               tolerance_255, p[0], p[1], p[2], p[3], q[0], q[1], q[2], q[3]);
  }
  if (excused <= mostExcused(a)) return testing::AssertionSuccess();
  return testing::AssertionFailure() << fmt::format("{} pixels of {} x {} are a matter of rounding",
                                                    excused, a.width, a.height);
}

testing::AssertionResult depthsWithin(double tolerance, const FloatPicture& a,
                                      const FloatPicture& b) {
  if (a.depth.size() != b.depth.size())
    return testing::AssertionFailure() << a.depth.size() << " against " << b.depth.size();
  // At almost no opacity, the depth is the quotient of two rounding errors.
  constexpr float kLeastOpacity = 1e-3F;
  int64_t compared = 0;
  int excused = 0;
  for (size_t i = 0; i < a.depth.size(); ++i) {
    if (a.rgba[4 * i + 3] < kLeastOpacity || b.rgba[4 * i + 3] < kLeastOpacity) continue;
    ++compared;
    if (std::abs(a.depth[i] - b.depth[i]) <= tolerance) continue;
    if (doubtOf(a, b, i) <= 0)
      return testing::AssertionFailure()
             << fmt::format("{} against {} at pixel {}, {}", a.depth[i], b.depth[i],
                            i % static_cast<size_t>(a.width), i / static_cast<size_t>(a.width));
    ++excused;
  }
  if (compared == 0) return testing::AssertionFailure() << "no pixel has a depth";
  if (excused > mostExcused(a))
    return testing::AssertionFailure() << excused << " depths are a matter of rounding";
  return testing::AssertionSuccess();
}

testing::AssertionResult boxesDrawTheSame(RenderScene& scene, FrameOptions options) {
  options.partition = Partition::kBlocks;
  const FloatPicture blocks = scene.draw(options);
  options.partition = Partition::kBoxes;
  return within(1, scene.draw(options), blocks);
}

double shownShare(const FloatPicture& picture) {
  int64_t shown = 0;
  for (size_t i = 3; i < picture.rgba.size(); i += 4) shown += picture.rgba[i] > 0.01F ? 1 : 0;
  return static_cast<double>(shown) / static_cast<double>(picture.rgba.size() / 4);
}

std::unique_ptr<MemorySource> cropped(VolumeSource& source, const Box3& voxels, int64_t time) {
  VolumeLayout layout = source.layout();
  const Box3 box = intersect(voxels, boxOf(layout.dims));
  std::vector<std::byte> bytes(static_cast<size_t>(box.count()) * bytesPerVoxel(layout.type));
  source.readRegion(time, box, bytes);
  layout.origin = worldFromIndex(layout, toDouble(box.lo));
  layout.dims = box.size();
  layout.time_steps = 1;
  return std::make_unique<MemorySource>(layout, std::move(bytes));
}

std::unique_ptr<MemorySource> middleOf(VolumeSource& source, Vec3i most_vox, int64_t time) {
  const Vec3i size = min(source.layout().dims, most_vox);
  const Vec3i lo = (source.layout().dims - size) / Vec3i{2, 2, 2};
  return cropped(source, {lo, lo + size}, time);
}

void RenderTest::SetUpTestSuite() {
  device_ = suiteDevice();
}

FrameOptions obliqueView(Projection projection, PictureSize size) {
  FrameOptions options;
  options.camera.projection = projection;
  options.camera.azimuth_deg = 33;
  options.camera.elevation_deg = 21;
  options.camera.zoom = 1.3;
  options.size = size;
  return options;
}

FrameOptions insideView(const VolumeLayout& layout, Vec3d share, Vec3d toward_share) {
  const Vec3d outer = toDouble(layout.dims - Vec3i{1, 1, 1});
  FrameOptions options;
  options.camera.projection = Projection::kPerspective;
  options.camera.field_of_view_deg = 70;
  options.camera.look_at = Camera::LookAt{worldFromIndex(layout, outer * share),
                                          worldFromIndex(layout, outer * toward_share)};
  options.camera.up = Vec3d{0.1, 1, 0.05};
  options.size = {96, 80};
  return options;
}

}  // namespace sluice

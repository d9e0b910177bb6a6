// RenderScene: a source drawn by the renderer and by the reference from the same options, so that a
// test states only its special options.
//
//   RenderScene scene(device(), *source, transfer, {.block_vox = 8, .lit = true});
//   EXPECT_TRUE(within(2, scene.draw(options), scene.reference(options)));
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "src/render/session/session.h"
#include "tests/support/float_picture.h"
#include "tests/support/memory_source.h"
#include "tests/support/reference_renderer.h"

namespace sluice {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

inline constexpr Projection kProjections[] = {Projection::kOrtho, Projection::kPerspective};

struct SceneOptions {
  int64_t block_vox = 16;  // a side; small, so that small volumes have many
  Vec3i page_vox{8, 8, 8};
  int64_t pages = 1 << 15;
  uint64_t memory_bytes = uint64_t{1} << 30;
  PolicyKind policy = PolicyKind::kLru;
  int threads = 2;
  bool lit = false;
  bool ghost = false;  // a ghost layer though unlit, for transfer functions that look at gradients
  int64_t time = 0;
  Partition partition = Partition::kBlocks;  // kBoxes: frames may draw either; keeps no index
};

class RenderScene {
 public:
  // The references must outlive the scene. The device may serve several scenes, one after another.
  RenderScene(Device& device, VolumeSource& source, TransferFunction transfer,
              const SceneOptions& options = {});

  // Also expects that no identity of the counters is broken, at any level.
  Frame frame(const FrameOptions& options);
  FloatPicture draw(const FrameOptions& options);
  // The picture that draw() promises.
  FloatPicture reference(const FrameOptions& options) const;

  // A session over another source with this scene's index, options and transfer function: the index
  // is built from this scene's source, so that a source may fail in the session alone. Must not
  // outlive the scene.
  std::unique_ptr<Session> sessionOver(VolumeSource& source);

  Session& session() { return *session_; }
  const SliceRanges& ranges() const { return *ranges_; }
  TimeStep step() const { return {&source_, options_.time, ranges_}; }
  void setTransfer(TransferFunction transfer);

 private:
  Device& device_;
  VolumeSource& source_;
  const SceneOptions options_;
  TransferFunction transfer_;
  WorkerPool pool_;
  std::shared_ptr<const SliceRanges> ranges_;
  std::unique_ptr<Session> session_;
};

// Least and greatest value of a time step that is a number, in a plain loop.
ValueRange valueRangeOf(VolumeSource& source, int64_t time = 0);

// Success when no channel differs by more than tolerance_255 / 255, and by the change that rounding
// may cause according to the reference (FloatPicture::doubt), which at most one pixel in 100 may
// need. Pictures of the renderer itself carry no doubt.
testing::AssertionResult within(double tolerance_255, const FloatPicture& a, const FloatPicture& b);
// The same for depths if both pictures are opaque enough to have one, in world units.
testing::AssertionResult depthsWithin(double tolerance, const FloatPicture& a,
                                      const FloatPicture& b);
// Success when the growing boxes, which the scene must allow, give the picture of the object boxes.
testing::AssertionResult boxesDrawTheSame(RenderScene& scene, FrameOptions options);
// Guards against comparing nothing with nothing: the share of pixels that show something.
double shownShare(const FloatPicture& picture);

// A part of a source, so that tests of large volumes stay quick. `source` must outlive it.
std::unique_ptr<MemorySource> cropped(VolumeSource& source, const Box3& voxels, int64_t time = 0);
// The middle of a source, of `most_vox` along each axis at most.
std::unique_ptr<MemorySource> middleOf(VolumeSource& source, Vec3i most_vox, int64_t time = 0);

// A test with the device of its program, see tests/device/suite_device.h.
class RenderTest : public testing::Test {
 protected:
  static void SetUpTestSuite();
  static void TearDownTestSuite() { device_.reset(); }
  static Device& device() { return *device_; }
  // How many of so many given bytes the device copies: none if it borrows.
  static uint64_t copied(uint64_t bytes) {
    return device().limits().texels == TexelPlace::kBorrowed ? 0 : bytes;
  }

 private:
  static inline std::unique_ptr<Device> device_;
};

// Views that need not care: turned about both axes, small.
FrameOptions obliqueView(Projection projection, PictureSize size = {96, 80});
// A perspective eye inside the volume, at `share` (0..1) of it along each axis.
FrameOptions insideView(const VolumeLayout& layout, Vec3d share, Vec3d toward_share);

}  // namespace sluice

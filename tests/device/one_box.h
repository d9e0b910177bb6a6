// A box of one value, which a device's tests draw. The library of the test links sluice_render.
#pragma once

#include <vector>

#include "src/device/device.h"
#include "src/render/camera/frame_setup.h"
#include "tests/support/plain_device.h"

namespace sluice {

inline constexpr Vec3i kBoxDims{8, 8, 8};

inline ChunkTexelsPtr texelsOf(int value) {
  return chunkTexels(kBoxDims, DeviceType::kU8,
                     std::vector<std::byte>(512, static_cast<std::byte>(value)));
}

inline FrameSetup setupOf(PictureSize size, double step_vox = 1) {
  VolumeLayout layout;
  layout.dims = kBoxDims;
  FrameOptions options;
  options.size = size;
  options.step_vox = step_vox;
  const ValueMap map = deviceMap(layout);
  const TransferFunction transfer{{{0, {0, 0, 1}}, {255, {1, 0, 0}}}, {{0, 0.01}, {255, 0.2}}, "t"};
  return frameSetup(resolve(options.camera, layout, size, step_vox), layout,
                    OpacityTable(transfer, map, {0, 255}), map, options);
}

inline BoxDraw wholeBox() {
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(kBoxDims - Vec3i{1, 1, 1});
  return box;
}

inline Picture draw(Device& device, const FrameSetup& setup) {
  const BoxDraw box = wholeBox();
  device.beginFrame(setup);
  device.draw({&box, 1});
  return device.endFrame();
}

}  // namespace sluice

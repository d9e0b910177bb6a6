#include "tests/support/plain_device.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "src/base/error.h"
#include "src/device/boxes_together.h"
#include "src/device/pictures/depth_code.h"
#include "tests/support/plain_lighting.h"
#include "tests/support/plain_rays.h"
#include "tests/support/plain_sampling.h"

namespace sluice {
void PlainDevice::makeResident(uint64_t id, ChunkTexelsPtr texels) {
  if (!options_.borrows) {
    uploaded_bytes_ += texels->byte_count;
    auto copy = std::make_shared<ChunkTexels>(*texels);
    copy->bytes = chunkTexels(texels->storage_vox, texels->type, texels->span())->bytes;
    texels = std::move(copy);
  }
  const bool fresh = resident_.emplace(id, std::move(texels)).second;
  SLUICE_CHECK(fresh);
}

void PlainDevice::evict(uint64_t id) {
  if (on_evict) on_evict();
  if (std::ranges::any_of(put_off_, [id](const BoxDraw& box) { return box.chunk == id; }))
    drawNow();
  const size_t gone = resident_.erase(id);
  SLUICE_CHECK_EQ(gone, size_t{1});
}

uint64_t PlainDevice::residentBytes() const {
  uint64_t bytes = 0;
  for (const auto& [id, texels] : resident_) bytes += texels->byte_count;
  return bytes;
}

void PlainDevice::beginFrame(const FrameSetup& setup, const StopToken& stop) {
  SLUICE_CHECK_LE(setup.clip_planes.size(), kMostClipPlanes);
  requirePictureSize(setup.size, limits());
  setup_ = setup;
  stop_ = stop;
  taken_ = 0;
  mean_look_.reset();
  if (setup.integrates) mean_look_.emplace(*setup.look_up);
  put_off_.clear();
  pixels_.assign(static_cast<size_t>(setup.size.width) * static_cast<size_t>(setup.size.height),
                 {});
}

void PlainDevice::draw(std::span<const BoxDraw> boxes) {
  if (on_draw) on_draw(boxes);
  for (size_t i = 0; i < boxes.size(); ++i) {
    SLUICE_CHECK(resident_.contains(boxes[i].chunk));
    if (i == 0 || boxes[i].chunk != boxes[i - 1].chunk) ++binds_;
    put_off_.push_back(boxes[i]);
  }
  if (!options_.puts_off) drawNow();
}

void PlainDevice::drawNow() {
  const std::vector<BoxDraw> boxes = std::exchange(put_off_, {});
  for (size_t i = 0; i < boxes.size();) {
    stop_.throwIfStopped();
    const size_t count = countTogether(std::span(boxes).subspan(i));
    drawBox(boxes[i], std::span(boxes).subspan(i + 1, count - 1));
    i += count;
  }
}

void PlainDevice::drawBox(const BoxDraw& box, std::span<const BoxDraw> joined) {
  joined_ = joined;
  const ChunkTexels& chunk = *resident_.at(box.chunk);
  eachPixelOf(box.cells, setup_, [&](int x, int y) {
    Pixel& pixel = at(x, y);
    if (!pixel.is_stopped) take(plainRayOf(setup_, x, y), box, chunk, pixel);
  });
  joined_ = {};
}

void PlainDevice::blend(const Sample& sample, Pixel& pixel) const {
  const double weight = (1 - pixel.opacity) * sample.opacity;
  const double dark = setup_.depth_cueing * placeOfDepth(sample.depth);
  pixel.rgb = pixel.rgb + sample.rgb * (weight * (1 - dark));
  pixel.depth_sum += weight * sample.depth;
  pixel.opacity += weight;
}

// Modes other than composite: takes a sample's value at slice k.
void PlainDevice::takeValue(const PlainRay& ray, double value, double k, Pixel& pixel) const {
  const bool replaces = pixel.count == 0 || (setup_.mode == Mode::kMip && value > pixel.value) ||
                        (setup_.mode == Mode::kMinip && value < pixel.value);
  const auto [lo, hi] = setup_.window;
  const double level = lo == hi ? 0 : std::clamp((value - lo) / (hi - lo), 0.0, 1.0);
  if (setup_.mode == Mode::kDepthMip) {
    // The greater of two places in whole steps wins, and of two in one step the nearer.
    const double step = std::floor(level * kPlaceSteps + kPlaceShift);
    const double depth = setup_.first_depth + (k + 0.5) * setup_.depth_step;
    if (pixel.count == 0 || step > pixel.value || (step == pixel.value && depth < pixel.depth)) {
      pixel.value = step;
      pixel.depth = depth;
    }
  } else if (setup_.mode == Mode::kAttenuatedMip) {
    pixel.value = std::max(pixel.value, level * (1 - pixel.dimmed));
    pixel.dimmed = 1 - (1 - pixel.dimmed) *
                           std::exp(-setup_.attenuation * level * setup_.slice_length * ray.length);
  } else if (setup_.mode == Mode::kAverage)
    pixel.value += value;
  else if (replaces)
    pixel.value = value;
  ++pixel.count;
}

void PlainDevice::take(const PlainRay& ray, const BoxDraw& box, const ChunkTexels& chunk,
                       Pixel& pixel) {
  if (box.beside) {
    const auto [from, to] = slicesIn(ray, box.cells, setup_);
    for (int64_t k = from; k < to; ++k)
      blendSurfaces(ray, box, chunk, static_cast<double>(k), {}, pixel);
    return;
  }
  const bool composite = setup_.mode == Mode::kComposite;
  const LookUp& look_up = *setup_.look_up;
  double in_box = 0;
  eachSample(ray, box, setup_, [&](Vec3d p, double k) {
    const auto texelAt = [&](Vec3d place, int a) {
      const auto& [axes, scale, offset] = box.texels;
      return place[axes[static_cast<size_t>(a)]] * scale[a] + offset[a];
    };
    Vec3d texel, texel_beside;
    for (int a = 0; a < 3; ++a) texel[a] = texelAt(p, a);
    // Beyond the outermost texels their values continue.
    for (int a = 0; a < 3; ++a)
      texel[a] = std::clamp(texel[a], 0.0, static_cast<double>(chunk.storage_vox[a] - 1));
    const bool labels = composite && look_up.labels;
    ++taken_;
    double value = 0;
    std::optional<ShownLabel> shown;
    std::array<double, 4> rgba{};
    if (setup_.integrates) {
      const auto valueBeside = [&](double slices) {
        const Vec3d place = p + ray.step * slices;
        for (int a = 0; a < 3; ++a)
          texel_beside[a] =
              std::clamp(texelAt(place, a), 0.0, static_cast<double>(chunk.storage_vox[a] - 1));
        return valueAt(chunk, texel_beside);
      };
      double front = valueBeside(-0.5), back = valueBeside(0.5);
      if (front < kNoNumber) front = back;
      if (back < kNoNumber) back = front;
      if (front < kNoNumber) return true;
      value = (front + back) / 2;
      rgba = mean_look_->between(front, back);
    } else {
      if (labels && chunk.has_spread) {
        shown = shownLabelAt(chunk, look_up, texel);
        value = shown->label;
      } else {
        value = labels ? labelAt(chunk, texel) : valueAt(chunk, texel);
      }
      if (value < kNoNumber && !setup_.has_surfaces) return true;
      if (value >= kNoNumber) rgba = lookedUp(look_up, value, look_up.interpolates || !composite);
    }
    const double spread = chunk.has_spread && composite && !labels ? spreadAt(chunk, texel) : 0;
    if (rgba[3] <= 0 && !(spread > 0)) {
      if (setup_.has_surfaces) blendSurfaces(ray, box, chunk, k, {}, pixel);
      return true;
    }
    if (!composite) {
      takeValue(ray, value, k, pixel);
      return true;
    }
    Vec3d gradient;  // camera space, device values a world unit
    double difference_squares = 0, axis_squares = 0;
    const bool has_slopes = setup_.lit || !look_up.magnitudes.empty();
    const bool is_wide = has_slopes && chunk.has_spread && composite && !labels;
    const Vec3d scale = box.texels.scale;
    const double texel_voxels = std::pow(scale.x * scale.y * scale.z, -1.0 / 3);
    const std::optional<WideSlopes> wide =
        is_wide ? wideSlopesAt(chunk, texel, texel_voxels) : std::nullopt;
    if (has_slopes)
      for (int a = 0; a < 3; ++a) {
        Vec3d after = texel, before = texel;
        after[a] += 1;
        before[a] -= 1;
        const double next = wide ? wide->slopes[a] : valueAt(chunk, after);
        const double last = wide ? -next : valueAt(chunk, before);
        const auto axis = static_cast<size_t>(box.texels.axes[static_cast<size_t>(a)]);
        const Vec3d a_texel = setup_.camera_gradient[axis] * box.texels.scale[a];
        axis_squares += dot(a_texel, a_texel);
        if (next < kNoNumber || last < kNoNumber) continue;
        gradient = gradient + a_texel * (0.5 * (next - last));
        difference_squares += 0.25 * (next - last) * (next - last);
      }
    const double factor = factorOf(look_up, length(gradient), value);
    const double lengths = setup_.slice_length * ray.length;
    const auto opacityOf = [&](double one) {
      if (!shown) return 1 - std::pow(1 - one * factor, lengths);
      return sharedOpacity(one * factor, shown->part, lengths, texel_voxels);
    };
    double opacity = opacityOf(rgba[3]);
    Vec3d rgb{rgba[0], rgba[1], rgba[2]};
    if (spread > 0) {
      const ExpectedEntry expected = expectedAt(*look_up.expected, value, spread);
      const double a = expected.rgba[3], whole = opacityOf(a), exact = 1 - expected.share;
      Vec3d sum = rgb * (opacity * exact);
      for (int c = 0; c < 3 && a > 0; ++c)
        sum[c] += expected.share * whole * expected.rgba[static_cast<size_t>(c)] / a;
      opacity = opacity * exact + expected.share * whole;
      if (!(opacity > 0)) {
        if (setup_.has_surfaces) blendSurfaces(ray, box, chunk, k, {}, pixel);
        return true;
      }
      rgb = sum / opacity;
    }
    if (setup_.lit && labels) {
      const Vec3d slopes = labelSlopesAt(chunk, look_up, texel);
      gradient = {};
      for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<size_t>(box.texels.axes[static_cast<size_t>(a)]);
        gradient = gradient + setup_.camera_gradient[axis] * (slopes[a] * box.texels.scale[a]);
      }
    }
    // A fifth of the variance beyond that of an even slope, along each axis; of noise, by the
    // voxel.
    const WideSlopes around = wide.value_or(WideSlopes{{}, 1, 1, spread, 0});
    const double noise = around.noise * texel_voxels;
    const double rough =
        std::max(0.0, around.spread * around.spread / 4 - difference_squares / 12) / 5 +
        0.08 * noise * noise;
    const PlainSlopes slopes{gradient, rough * axis_squares, around.here, around.seen};
    if (setup_.lit) rgb = litPlainly(setup_, p, rgb, slopes, setup_.flat);
    const Sample sample{rgb, opacity,
                        setup_.first_depth + (k + ray.jitter + 0.5) * setup_.depth_step};
    if (setup_.has_surfaces)
      blendSurfaces(ray, box, chunk, k, sample, pixel);
    else
      blend(sample, pixel);
    in_box += (1 - in_box) * opacity;
    return in_box < setup_.opacity_threshold || setup_.opacity_threshold >= 1;
  });
}

std::vector<float> PlainDevice::leastOpacity(const MapGrid& grid) {
  drawNow();
  const auto [width, height] = setup_.size;
  std::vector<float> least;
  for (int j = 0; j < grid.side; ++j)
    for (int i = 0; i < grid.side; ++i) {
      double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
      bool reaches_eye = false;
      for (int corner = 0; corner < 4; ++corner) {
        const Vec3d at{i + static_cast<double>(corner & 1), j + static_cast<double>(corner >> 1),
                       1};
        std::array<double, 3> clip{};
        for (size_t r = 0; r < 3; ++r)
          clip[r] = dot(
              {grid.clip_from_map[r][0], grid.clip_from_map[r][1], grid.clip_from_map[r][2]}, at);
        reaches_eye = reaches_eye || clip[2] <= 0;
        const double x = (clip[0] / clip[2] + 1) / 2 * width;
        const double y = (clip[1] / clip[2] + 1) / 2 * height;
        x0 = std::min(x0, x), x1 = std::max(x1, x);
        y0 = std::min(y0, y), y1 = std::max(y1, y);
      }
      double cell = reaches_eye ? 0 : 1;
      // Pixels whose centre may lie in it.
      for (int y = std::max(0, clampedInt(y0 - 1)); y < std::min(height, clampedInt(y1 + 1)); ++y)
        for (int x = std::max(0, clampedInt(x0 - 1)); x < std::min(width, clampedInt(x1 + 1)); ++x)
          if (x + 0.5 >= x0 - 1e-6 && x + 0.5 <= x1 + 1e-6 && y + 0.5 >= y0 - 1e-6 &&
              y + 0.5 <= y1 + 1e-6)
            cell = std::min(cell, at(x, y).opacity);
      // Single precision may have rounded up.
      least.push_back(std::nextafter(static_cast<float>(cell), 0.0F));
    }
  return least;
}

void PlainDevice::stopOpaque() {
  drawNow();
  for (Pixel& pixel : pixels_) pixel.is_stopped = pixel.opacity >= setup_.opacity_threshold;
}

uint64_t PlainDevice::countSamples(std::span<const BoxDraw> boxes) {
  uint64_t samples = 0;
  for (const BoxDraw& box : boxes)
    eachPixelOf(box.cells, setup_, [&](int x, int y) {
      eachSample(plainRayOf(setup_, x, y), box, setup_, [&](Vec3d, double) {
        ++samples;
        return true;
      });
    });
  return samples;
}

double PlainDevice::placeOfDepth(double depth) const {
  const auto [near, far] = setup_.shown_depths;
  return far > near ? std::clamp((depth - near) / (far - near), 0.0, 1.0) : 0;
}

Picture PlainDevice::endFrame() {
  drawNow();
  stop_.throwIfStopped();
  Picture picture = std::exchange(spare_, {});
  const auto [width, height] = setup_.size;
  picture.width = width;
  picture.height = height;
  picture.rgba.clear();
  picture.depth.clear();
  for (int row = 0; row < height; ++row)
    for (int x = 0; x < width; ++x) {
      const Pixel& pixel = at(x, height - 1 - row);
      std::array<double, 4> rgba{pixel.rgb.x, pixel.rgb.y, pixel.rgb.z, pixel.opacity};
      if (setup_.mode != Mode::kComposite && setup_.is_part) {
        const bool sums = setup_.mode == Mode::kAverage, seen = pixel.count > 0;
        const bool greatest = setup_.mode == Mode::kMip || setup_.mode == Mode::kDepthMip;
        rgba[0] = !seen ? traitsOf(setup_.mode).first_value
                  : setup_.mode == Mode::kDepthMip
                      ? depthCode((pixel.value) / kPlaceSteps, placeOfDepth(pixel.depth))
                      : pixel.value;
        rgba[1] = sums ? static_cast<double>(pixel.count) : greatest && seen ? 1 : pixel.dimmed;
        rgba[2] = setup_.mode == Mode::kAttenuatedMip && seen ? 1 : 0;
      } else if (setup_.mode == Mode::kDepthMip && pixel.count > 0) {
        const auto& colors = setup_.depth_colors;
        const double at = placeOfDepth(pixel.depth) * static_cast<double>(colors.size() - 1);
        const auto before = static_cast<size_t>(at);
        const Vec3d a = colors[before], b = colors[std::min(before + 1, colors.size() - 1)];
        const double part = at - static_cast<double>(before);
        const Vec3d rgb = (a * (1 - part) + b * part) * std::min(pixel.value / kPlaceSteps, 1.0);
        rgba = {rgb.x, rgb.y, rgb.z, 1};
      } else if (setup_.mode != Mode::kComposite && pixel.count > 0) {
        const double taken = setup_.mode == Mode::kAverage ? static_cast<double>(pixel.count) : 1;
        const double value = setup_.mode == Mode::kAttenuatedMip
                                 ? std::lerp(setup_.window[0], setup_.window[1], pixel.value)
                                 : pixel.value / taken;
        rgba = lookedUp(*setup_.look_up, value, false);
        rgba[3] = 1;
      }
      for (const double channel : rgba) picture.rgba.push_back(static_cast<float>(channel));
      if (setup_.mode == Mode::kComposite && setup_.with_depth)
        picture.depth.push_back(pixel.opacity > 0
                                    ? static_cast<float>(pixel.depth_sum / pixel.opacity)
                                    : std::numeric_limits<float>::infinity());
    }
  return picture;
}

ChunkTexelsPtr chunkTexels(Vec3i storage_vox, DeviceType type, std::span<const std::byte> bytes) {
  auto chunk = std::make_shared<ChunkTexels>();
  chunk->storage_vox = chunk->size_vox = storage_vox;
  chunk->type = type;
  chunk->byte_count = bytes.size();
  chunk->bytes = std::make_shared_for_overwrite<std::byte[]>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), chunk->bytes.get());
  return chunk;
}

}  // namespace sluice

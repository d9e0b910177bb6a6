// The slopes of the opacity of labels, on which their light falls. Included once a target.

// One texel a lane, from an offset in bytes.
template <DeviceType kType>
HWY_INLINE V texelsFrom(const std::byte* base, VI offset) {
  using T = std::conditional_t<kType == DeviceType::kU8, uint8_t,
                               std::conditional_t<kType == DeviceType::kU16, uint16_t, float>>;
  alignas(64) int32_t offsets[kMostLanes];
  alignas(64) float values[kMostLanes];
  hn::Store(offset, I(), offsets);
  for (int lane = 0; lane < kLanes; ++lane) {
    T value;
    __builtin_memcpy(&value, base + offsets[lane], sizeof value);
    values[lane] = static_cast<float>(value);
  }
  return hn::Load(F(), values);
}

// The opacity of a unit length of a label; a voxel that is no number has none.
template <DeviceType kType>
HWY_INLINE V labelOpacityOf(const KernelFrame& frame, V label) {
  const VI entry = wholeOf(hn::Add(entryOf(frame, label), all(0.5F)));
  const V opacity = floatsAt(frame.label_entries + 3, hn::ShiftLeft<2>(entry));
  if constexpr (kType == DeviceType::kF32)
    return hn::IfThenZeroElse(isNoNumber(label), opacity);
  else
    return opacity;
}

// Sobel's weights along an axis, interpolated between two texels: of the texel before a place, the
// two around it and the one behind it, for the slope along the axis and for a mean across it.
struct SobelWeights {
  V slope[4], mean[4];
};
HWY_INLINE SobelWeights sobelWeights(V part) {
  const V half = hn::Mul(all(0.5F), part), quarter = hn::Mul(all(0.25F), part);
  const V rest = hn::Sub(all(0.5F), half);
  return {{hn::Neg(rest), hn::Neg(half), rest, half},
          {hn::Sub(all(0.25F), quarter), hn::Sub(all(0.5F), quarter),
           hn::Add(all(0.25F), quarter), quarter}};
}

// The offsets of four texels along an axis, from the one before a cell on, cut by the chunk.
struct FourOffsets {
  VI of[4];
};
HWY_INLINE FourOffsets offsetsAround(const KernelBox& box, V cell, size_t axis) {
  FourOffsets offsets;
  const V lo = all(box.storage_lo[axis]), hi = all(box.storage_hi[axis]);
  for (int i = 0; i < 4; ++i) {
    const V texel = hn::Add(cell, all(static_cast<float>(i - 1)));
    offsets.of[i] = wholeOf(hn::Mul(hn::Min(hn::Max(texel, lo), hi), all(box.stride[axis])));
  }
  return offsets;
}

// The labels of the 4 x 4 x 4 texels around a cell, x fastest.
struct LabelsAround {
  alignas(64) float of[64][kMostLanes];
  HWY_INLINE V at(int i) const { return hn::Load(F(), of[i]); }
};
template <DeviceType kType, bool kSpread>
HWY_INLINE void readWithMargin(const KernelBox& box, VI offset, LabelsAround& labels) {
  const auto y = static_cast<int64_t>(box.stride[1]), z = static_cast<int64_t>(box.stride[2]);
  for (int k = 0; k < 4; ++k) {
    const int64_t plane = (k - 1) * z;
    const LongRows rows =
        longRowsAt<kType, kSpread>(box, offset, {plane - y, plane, plane + y, plane + 2 * y});
    for (int j = 0; j < 4; ++j) {
      float(*const row)[kMostLanes] = labels.of + 16 * k + 4 * j;
      hn::Store(rows.before[j], F(), row[0]);
      hn::Store(rows.first[j], F(), row[1]);
      hn::Store(rows.second[j], F(), row[2]);
      hn::Store(rows.after[j], F(), row[3]);
    }
  }
}
// Beyond the chunk its outermost texels continue.
template <DeviceType kType>
HWY_INLINE void readWithoutMargin(const KernelBox& box, const V3& cell, LabelsAround& labels) {
  const FourOffsets x = offsetsAround(box, cell.x, 0), y = offsetsAround(box, cell.y, 1),
                    z = offsetsAround(box, cell.z, 2);
  for (int i = 0; i < 64; ++i) {
    const VI row = hn::Add(y.of[i / 4 % 4], z.of[i / 16]);
    const V label = texelsFrom<kType>(box.texels, hn::Add(x.of[i % 4], row));
    hn::Store(label, F(), labels.of[i]);
  }
}

// Sobel's operator at the eight texels around a place, interpolated, on numbers of the texels around.
template <class NumberOf>
HWY_INLINE V3 sobelSlopes(const Place& place, const NumberOf& number_of) {
  const SobelWeights x = sobelWeights(place.fx), y = sobelWeights(place.fy),
                     z = sobelWeights(place.fz);
  V3 slopes{hn::Zero(F()), hn::Zero(F()), hn::Zero(F())};
  for (int row = 0; row < 16; ++row) {
    const int j = row % 4, k = row / 4;
    V slope = hn::Zero(F()), mean = hn::Zero(F());
    for (int i = 0; i < 4; ++i) {
      const V number = number_of(4 * row + i);
      slope = hn::MulAdd(x.slope[i], number, slope);
      mean = hn::MulAdd(x.mean[i], number, mean);
    }
    slopes.x = hn::MulAdd(hn::Mul(y.mean[j], z.mean[k]), slope, slopes.x);
    slopes.y = hn::MulAdd(hn::Mul(y.slope[j], z.mean[k]), mean, slopes.y);
    slopes.z = hn::MulAdd(hn::Mul(y.mean[j], z.slope[k]), mean, slopes.z);
  }
  return slopes;
}

// The change of the labels' opacity from texel to texel along each axis. A call of its own, since few
// frames draw labels. Two labels at most around a place are so common that no others are looked up.
template <DeviceType kType, bool kSpread>
HWY_NOINLINE V3 labelSlopesAt(const KernelFrame& frame, const KernelBox& box, V3 at, Place place) {
  LabelsAround labels;
  if (box.has_margin)
    readWithMargin<kType, kSpread>(box, place.offset, labels);
  else
    readWithoutMargin<kType>(
        box, {hn::Sub(at.x, place.fx), hn::Sub(at.y, place.fy), hn::Sub(at.z, place.fz)}, labels);
  V least = labels.at(0), greatest = least;
  for (int i = 1; i < 64; ++i) {
    least = hn::Min(least, labels.at(i));
    greatest = hn::Max(greatest, labels.at(i));
  }
  const V jump = hn::Sub(labelOpacityOf<kType>(frame, greatest),
                         labelOpacityOf<kType>(frame, least));
  M other = hn::MaskFromVec(hn::Zero(F()));
  for (int i = 0; i < 64; ++i)
    other = hn::Or(other, hn::And(hn::Gt(labels.at(i), least), hn::Lt(labels.at(i), greatest)));
  if (hn::AllFalse(F(), other)) {
    if (hn::AllTrue(F(), hn::Eq(jump, hn::Zero(F())))) return {jump, jump, jump};
    return sobelSlopes(place, [&](int i) {
      return hn::IfThenElseZero(hn::Eq(labels.at(i), greatest), jump);
    });
  }
  return sobelSlopes(place, [&](int i) { return labelOpacityOf<kType>(frame, labels.at(i)); });
}

// Labels by their opacities: the shares of those that show, see label_shares.h, and the slopes on
// which light falls. Included once a target.

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

// The others' share of a texel, 0 to 1.
template <DeviceType kType>
HWY_INLINE V othersShareOf(V number) {
  const V unit = all(static_cast<float>(1 / wholeShare(kType)));
  return hn::Min(hn::Max(hn::Mul(number, unit), hn::Zero(F())), all(1.0F));
}

// The measure of a body that a label is, 0 to 1, from the greatest share of it around.
HWY_INLINE V bodyOf(V fullest) {
  return hn::Min(hn::Max(hn::MulAdd(all(4.0F), fullest, all(-2.0F)), hn::Zero(F())), all(1.0F));
}

// The label of a sample in a chunk with shares, and the part that shows of a whole voxel's opacity.
// A call of its own, as labelAt() is. Most places lie within one label.
struct SharedLabel {
  V label, part;
};
template <DeviceType kType>
HWY_NOINLINE SharedLabel sharedLabelAt(const KernelFrame& frame, const KernelBox& box,
                                       Place place) {
  const SpreadRows rows = spreadRowsAround<kType>(box, place.offset);
  const EightNumbers values = eightOf(rows.mean), others = eightOf(rows.spread);
  const V none = hn::Zero(F()), whole = all(1.0F);
  EightNumbers weights = weightsAt(place);
  V least = values.at(0), greatest = least;
  for (int i = 1; i < 8; ++i) {
    least = hn::Min(least, values.at(i));
    greatest = hn::Max(greatest, values.at(i));
  }
  const bool is_one = hn::AllTrue(F(), hn::Eq(least, greatest));
  const M one_shows = hn::Gt(labelOpacityOf<kType>(frame, least), none);
  V shown = none, left = none, fullest = none;
  for (int i = 0; i < 8; ++i) {
    const V weight = weights.at(i);
    const M shows =
        is_one ? one_shows : hn::Gt(labelOpacityOf<kType>(frame, values.at(i)), none);
    const V rest = othersShareOf<kType>(others.at(i)), share = hn::Sub(whole, rest);
    shown = hn::MulAdd(weight, hn::IfThenElseZero(shows, share), shown);
    left = hn::MulAdd(weight, hn::IfThenZeroElse(shows, rest), left);
    fullest = hn::Max(fullest, hn::IfThenElseZero(shows, share));
    // Below what any label that shows has together: those win.
    hn::Store(hn::IfThenElse(shows, weight, all(-2.0F)), F(), weights.of[i]);
  }
  const V body = bodyOf(fullest), share = hn::MulAdd(body, left, shown);
  const V step =
      hn::Min(hn::Max(hn::MulAdd(all(2.0F), share, all(-0.5F)), hn::Zero(F())), whole);
  return {is_one ? least : heaviestOf(values, weights),
          between(share, step, body, hn::Sub(whole, body))};
}


// The labels of the 4 x 4 x 4 texels around a cell, x fastest, and in chunks with shares the numbers
// that stand for the others' shares.
struct NumbersAround {
  alignas(64) float of[64][kMostLanes];
  HWY_INLINE V at(int i) const { return hn::Load(F(), of[i]); }
  HWY_INLINE void setRow(int row, V before, V first, V second, V after) {
    hn::Store(before, F(), of[4 * row]);
    hn::Store(first, F(), of[4 * row + 1]);
    hn::Store(second, F(), of[4 * row + 2]);
    hn::Store(after, F(), of[4 * row + 3]);
  }
};
struct LabelsAround {
  NumbersAround labels, others;
};
template <DeviceType kType, bool kSpread>
HWY_INLINE void readWithMargin(const KernelBox& box, VI offset, LabelsAround& around) {
  const auto x = static_cast<int64_t>(box.stride[0]), y = static_cast<int64_t>(box.stride[1]),
             z = static_cast<int64_t>(box.stride[2]);
  for (int k = 0; k < 4; ++k) {
    const int64_t plane = (k - 1) * z;
    const int64_t more[4] = {plane - y, plane, plane + y, plane + 2 * y};
    if constexpr (kSpread) {
      const WideRows<kType> rows =
          wideRowsAt<kType>(box, offset, {more[0] - x, more[1] - x, more[2] - x, more[3] - x});
      for (int j = 0; j < 4; ++j) {
        const auto [labels, others] = rows.row(j);
        around.labels.setRow(4 * k + j, labels[0], labels[1], labels[2], labels[3]);
        around.others.setRow(4 * k + j, others[0], others[1], others[2], others[3]);
      }
    } else {
      const LongRows rows = longRowsAt<kType, false>(box, offset, more);
      for (int j = 0; j < 4; ++j)
        around.labels.setRow(4 * k + j, rows.before[j], rows.first[j], rows.second[j],
                             rows.after[j]);
    }
  }
}
// Beyond the chunk its outermost texels continue.
template <DeviceType kType, bool kSpread>
HWY_INLINE void readWithoutMargin(const KernelBox& box, const V3& cell, LabelsAround& around) {
  const FourOffsets x = offsetsAround(box, cell.x, 0), y = offsetsAround(box, cell.y, 1),
                    z = offsetsAround(box, cell.z, 2);
  for (int i = 0; i < 64; ++i) {
    const VI offset = hn::Add(x.of[i % 4], hn::Add(y.of[i / 4 % 4], z.of[i / 16]));
    hn::Store(texelsFrom<kType>(box.texels, offset), F(), around.labels.of[i]);
    if constexpr (kSpread) {
      const auto second = static_cast<int64_t>(box.stride[0]) / 2;
      hn::Store(texelsFrom<kType>(box.texels + second, offset), F(), around.others.of[i]);
    }
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

// The share of a texel that shows where one label alone does: its own, or what a hidden label
// leaves to it.
HWY_INLINE V partOf(M shows, V rest, V body) {
  return hn::IfThenElse(shows, hn::Sub(all(1.0F), rest), hn::Mul(body, rest));
}

// The slopes where three labels or more lie around some place. `kSpread`: where one label alone
// shows, they are those of its share.
template <DeviceType kType, bool kSpread>
HWY_NOINLINE V3 slopesOfMany(const KernelFrame& frame, const Place& place,
                             const LabelsAround& around) {
  NumbersAround opacities;
  V least = all(3e38F), greatest = all(-3e38F), opacity = hn::Zero(F());
  for (int i = 0; i < 64; ++i) {
    const V label = around.labels.at(i), one = labelOpacityOf<kType>(frame, label);
    const M shows = hn::Gt(one, hn::Zero(F()));
    least = hn::IfThenElse(shows, hn::Min(least, label), least);
    greatest = hn::IfThenElse(shows, hn::Max(greatest, label), greatest);
    opacity = hn::Max(opacity, one);
    hn::Store(one, F(), opacities.of[i]);
  }
  if constexpr (kSpread) {
    const M is_one = hn::Eq(least, greatest);
    V fullest = hn::Zero(F());
    for (int i = 0; i < 64; ++i) {
      const V share = hn::Sub(all(1.0F), othersShareOf<kType>(around.others.at(i)));
      const M shows = hn::Gt(opacities.at(i), hn::Zero(F()));
      fullest = hn::Max(fullest, hn::IfThenElseZero(shows, share));
    }
    const V body = bodyOf(fullest);
    for (int i = 0; i < 64; ++i) {
      const V one = opacities.at(i), rest = othersShareOf<kType>(around.others.at(i));
      const V part = partOf(hn::Gt(one, hn::Zero(F())), rest, body);
      hn::Store(hn::IfThenElse(is_one, hn::Mul(opacity, part), one), F(), opacities.of[i]);
    }
  }
  return sobelSlopes(place, [&](int i) { return opacities.at(i); });
}

#if HWY_TARGET != HWY_SCALAR
// The labels of the 4 x 4 x 4 texels around a cell as they are stored: a lane has four bytes a row.
struct BytesAround {
  VI of[16];
};
HWY_INLINE BytesAround bytesAround(const KernelBox& box, VI offset) {
  const auto y = static_cast<int64_t>(box.stride[1]), z = static_cast<int64_t>(box.stride[2]);
  BytesAround around;
  for (int k = 0; k < 4; ++k) {
    const std::byte* row = box.texels + (k - 1) * z - 1;
    VI rows[4];
    fourAtOnce({row - y, row, row + y, row + 2 * y}, offset, rows);
    for (int j = 0; j < 4; ++j) around.of[4 * k + j] = rows[j];
  }
  return around;
}
using Bytes = hn::Repartition<uint8_t, F>;
using VB = hn::Vec<Bytes>;
HWY_INLINE VB bytesOf(VI number) { return hn::BitCast(Bytes(), number); }
template <int kBits>
HWY_INLINE VB turned(VB bytes) {
  const VI four = hn::BitCast(I(), bytes);
  return bytesOf(hn::Or(hn::ShiftLeft<kBits>(four),
                        hn::And(hn::ShiftRight<32 - kBits>(four),
                                hn::Set(I(), static_cast<int32_t>((1U << kBits) - 1)))));
}
// The least and the greatest of a lane's four bytes, four times each.
HWY_INLINE VB leastOfFour(VB bytes) {
  const VB two = hn::Min(bytes, turned<16>(bytes));
  return hn::Min(two, turned<8>(two));
}
HWY_INLINE VB greatestOfFour(VB bytes) {
  const VB two = hn::Max(bytes, turned<16>(bytes));
  return hn::Max(two, turned<8>(two));
}
// A lane's label, of which it has four copies.
HWY_INLINE V labelOf(VB bytes) {
  return hn::ConvertTo(F(), hn::And(hn::BitCast(I(), bytes), hn::Set(I(), 255)));
}

// labelSlopesAt() of bytes. Most places have one label around them, and nearly all others two or
// three: these are looked up once each.
HWY_NOINLINE V3 slopesOfBytes(const KernelFrame& frame, const KernelBox& box, Place place) {
  const BytesAround around = bytesAround(box, place.offset);
  VB least = bytesOf(around.of[0]), greatest = least;
  for (int row = 1; row < 16; ++row) {
    least = hn::Min(least, bytesOf(around.of[row]));
    greatest = hn::Max(greatest, bytesOf(around.of[row]));
  }
  least = leastOfFour(least);
  greatest = greatestOfFour(greatest);
  const V zero = hn::Zero(F());
  if (hn::AllTrue(Bytes(), hn::Eq(least, greatest))) return {zero, zero, zero};

  VB second = greatest;  // the least one above `least`
  for (int row = 0; row < 16; ++row) {
    const VB labels = bytesOf(around.of[row]);
    second = hn::Min(second, hn::IfThenElse(hn::Eq(labels, least), greatest, labels));
  }
  second = leastOfFour(second);
  const V low = labelOpacityOf<DeviceType::kU8>(frame, labelOf(least)),
          high = labelOpacityOf<DeviceType::kU8>(frame, labelOf(greatest));
  const VI whole_greatest = hn::BitCast(I(), greatest), whole_second = hn::BitCast(I(), second);
  const auto isIn = [&](int i, VI label) {
    const VI byte = hn::Set(I(), static_cast<int32_t>(255U << (8 * (i % 4))));
    return hn::RebindMask(
        F(), hn::Eq(hn::And(hn::Xor(around.of[i / 4], label), byte), hn::Zero(I())));
  };
  if (hn::AllTrue(Bytes(), hn::Eq(second, greatest))) {
    const V jump = hn::Sub(high, low);
    if (hn::AllTrue(F(), hn::Eq(jump, zero))) return {jump, jump, jump};
    return sobelSlopes(
        place, [&](int i) { return hn::IfThenElseZero(isIn(i, whole_greatest), jump); });
  }

  VB between_both = second;  // the greatest one below `greatest`
  for (int row = 0; row < 16; ++row) {
    const VB labels = bytesOf(around.of[row]);
    between_both =
        hn::Max(between_both, hn::IfThenElse(hn::Eq(labels, greatest), second, labels));
  }
  if (hn::AllTrue(Bytes(), hn::Eq(between_both, second))) {
    const V middle = labelOpacityOf<DeviceType::kU8>(frame, labelOf(second));
    return sobelSlopes(place, [&](int i) {
      return hn::IfThenElse(isIn(i, whole_greatest), high,
                            hn::IfThenElse(isIn(i, whole_second), middle, low));
    });
  }
  LabelsAround labels;
  for (int i = 0; i < 64; ++i) {
    const VI down = hn::Set(I(), 8 * (i % 4));
    hn::Store(hn::ConvertTo(F(), hn::And(hn::Shr(around.of[i / 4], down), hn::Set(I(), 255))), F(),
              labels.labels.of[i]);
  }
  return slopesOfMany<DeviceType::kU8, false>(frame, place, labels);
}
#endif

// The slopes that light labels, see lighting.h and label_shares.h, from texel to texel along each
// axis. A call of its own, since few frames draw labels. Two labels at most around a place are so
// common that no others are looked up.
template <DeviceType kType, bool kSpread>
HWY_NOINLINE V3 labelSlopesAt(const KernelFrame& frame, const KernelBox& box, V3 at, Place place) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (kType == DeviceType::kU8 && !kSpread)
    if (box.has_margin) return slopesOfBytes(frame, box, place);
#endif
  LabelsAround around;
  if (box.has_margin)
    readWithMargin<kType, kSpread>(box, place.offset, around);
  else
    readWithoutMargin<kType, kSpread>(
        box, {hn::Sub(at.x, place.fx), hn::Sub(at.y, place.fy), hn::Sub(at.z, place.fz)}, around);
  const NumbersAround& labels = around.labels;
  V least = labels.at(0), greatest = least;
  for (int i = 1; i < 64; ++i) {
    least = hn::Min(least, labels.at(i));
    greatest = hn::Max(greatest, labels.at(i));
  }
  const V zero = hn::Zero(F());
  if (!kSpread && hn::AllTrue(F(), hn::Eq(least, greatest))) return {zero, zero, zero};
  M other = hn::MaskFromVec(zero);
  for (int i = 0; i < 64; ++i)
    other = hn::Or(other, hn::And(hn::Gt(labels.at(i), least), hn::Lt(labels.at(i), greatest)));
  if (!hn::AllFalse(F(), other)) return slopesOfMany<kType, kSpread>(frame, place, around);
  const V low = labelOpacityOf<kType>(frame, least), high = labelOpacityOf<kType>(frame, greatest);
  const V jump = hn::Sub(high, low);
  if constexpr (kSpread) {
    const V most = hn::Max(low, high);
    const M low_shows = hn::Gt(low, zero), high_shows = hn::Gt(high, zero);
    const M both = hn::And(hn::And(low_shows, high_shows), hn::Ne(least, greatest));
    const auto showsAt = [&](int i) {
      const M is_high = hn::Eq(labels.at(i), greatest);
      return hn::Or(hn::And(is_high, high_shows), hn::AndNot(is_high, low_shows));
    };
    V fullest = zero;
    for (int i = 0; i < 64; ++i) {
      const V share = hn::Sub(all(1.0F), othersShareOf<kType>(around.others.at(i)));
      fullest = hn::Max(fullest, hn::IfThenElseZero(showsAt(i), share));
    }
    const V body = bodyOf(fullest);
    return sobelSlopes(place, [&](int i) {
      const V rest = othersShareOf<kType>(around.others.at(i));
      const V steps = hn::IfThenElseZero(hn::Eq(labels.at(i), greatest), jump);
      return hn::IfThenElse(both, steps, hn::Mul(most, partOf(showsAt(i), rest, body)));
    });
  } else {
    if (hn::AllTrue(F(), hn::Eq(jump, zero))) return {jump, jump, jump};
    return sobelSlopes(
        place, [&](int i) { return hn::IfThenElseZero(hn::Eq(labels.at(i), greatest), jump); });
  }
}

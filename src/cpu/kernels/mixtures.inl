// The colours that blended channels show in the slices between two looks. Included once a target.

// Slices between two looks for what to leap over; of each the channels' samples are kept.
constexpr int kSlicesAtOnce = 8;
constexpr float kMostAtOnce = kSlicesAtOnce;

// The colours that the channels show in a slice, added up.
struct Mixture {
  Color sum;
  V clear;  // the product of 1 - opacity
};

// The mixtures of the slices between two looks. Bit j of `shown` is set if slice j shows something,
// and bit j of `mixed` if more than one channel shows there. A mixture is set if its slice shows.
struct Mixtures {
  std::array<Mixture, kSlicesAtOnce> of;
  uint32_t shown = 0, mixed = 0;
};

// Adds the colour of a channel at slice j to the rays on which it shows.
HWY_INLINE void addColor(const Color& color, const M& shows, int j, Mixtures& mixtures) {
  const uint32_t bit = uint32_t{1} << j;
  Mixture& to = mixtures.of[static_cast<size_t>(j)];
  const Color seen{hn::IfThenElseZero(shows, color.r), hn::IfThenElseZero(shows, color.g),
                   hn::IfThenElseZero(shows, color.b), hn::IfThenElseZero(shows, color.a)};
  const V clear = hn::Sub(all(1.0F), seen.a);
  // The first channel's colour is kept as it is: most slices show one channel alone.
  if ((mixtures.shown & bit) == 0) {
    to = {seen, clear};
    mixtures.shown |= bit;
    return;
  }
  to.sum = {hn::Add(to.sum.r, seen.r), hn::Add(to.sum.g, seen.g), hn::Add(to.sum.b, seen.b),
            hn::Add(to.sum.a, seen.a)};
  to.clear = hn::Mul(to.clear, clear);
  mixtures.mixed |= bit;
}

// The colour of a slice: opacities multiply as those of media that fill the same space do, and the
// colours are the mean by opacity.
HWY_INLINE Color colorOf(const Mixture& mixture) {
  const V a = hn::Sub(all(1.0F), mixture.clear);
  const V scale = hn::Div(a, hn::Max(mixture.sum.a, all(1e-20F)));
  return {hn::Mul(mixture.sum.r, scale), hn::Mul(mixture.sum.g, scale),
          hn::Mul(mixture.sum.b, scale), a};
}

// The places at which surfaces look for the values of slices, see FrameSetup::has_surfaces. Included
// once a target.

// A product and a sum that are each rounded with all instructions, while MulAdd() rounds once where
// there are such instructions. The places of slices are rounded to a grid (FrameSetup::has_surfaces)
// and would otherwise fall on other points of it.
HWY_INLINE V roundedMulAdd(V a, V b, V more) { return hn::Add(hn::Mul(a, b), more); }
HWY_INLINE V roundedPlane(float base, float dx, float dy, const Packet& packet) {
  return roundedMulAdd(packet.py, all(dy), roundedMulAdd(packet.px, all(dx), all(base)));
}

// The slices of a ray as surfaces look for them, in voxels from placeBase(): the place from which
// they count, and the way from one to the next.
struct SlicePlaces {
  V3 origin, step;
};
HWY_INLINE SlicePlaces slicePlacesOf(const KernelFrame& frame, const Packet& packet) {
  const auto along = [&](size_t axis, V& origin, V& step) {
    step = roundedPlane(frame.step0[axis], frame.step_dx[axis], frame.step_dy[axis], packet);
    origin = roundedPlane(frame.place_origin[axis], frame.origin_dx[axis], frame.origin_dy[axis],
                          packet);
    origin = roundedMulAdd(packet.jitter, step, origin);
  };
  SlicePlaces places;
  along(0, places.origin.x, places.step.x);
  along(1, places.origin.y, places.step.y);
  along(2, places.origin.z, places.step.z);
  return places;
}

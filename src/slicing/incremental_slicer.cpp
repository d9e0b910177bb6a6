#include "src/slicing/incremental_slicer.h"

#include <algorithm>
#include <cmath>

namespace sluice {
namespace {

// Corners are numbered from the eye: bit a is set if a corner lies on the far face of axis a, so
// that every edge leads from a corner to one with a bit more, and 0 is passed first and 7 last.

// The axes of the edges that begin at a corner, in the polygon's order.
struct Connection {
  int count = 0;
  std::array<int, 3> axes{};
};
// Connections by corner, for views that look down an even number of axes from their far end, and an
// odd number: in a mirror the same order turns the other way.
using Connections = std::array<std::array<Connection, 8>, 2>;

constexpr Connections makeConnections() {
  Connections all{};
  for (const bool odd : {false, true})
    for (int corner = 0; corner < 8; ++corner) {
      Connection& next = all[odd ? 1 : 0][static_cast<size_t>(corner)];
      int from = 0;
      for (int a = 0; a < 3; ++a)
        if ((corner >> a & 1) != 0) from = a;
      for (int i = 3; i > 0; --i) {
        const int axis = (from + i) % 3;
        if ((corner >> axis & 1) == 0) next.axes[static_cast<size_t>(next.count++)] = axis;
      }
      // The edges that leave the nearest corner form the first polygon, x, z, y. At any other
      // corner two edges follow an edge along axis a: the first, a + 1 in this order, shares a face
      // with the vertex before, the second with the vertex behind.
      const bool turns = (corner == 0) == odd;
      if (turns) std::reverse(next.axes.begin(), next.axes.begin() + next.count);
    }
  return all;
}
constexpr Connections kConnections = makeConnections();

// An active intersection, on the edge that leaves `corner` along `axis`.
struct Intersection {
  Vec3d position, texture;
  int corner = 0, axis = 0;
  bool fresh = true;  // has no position yet

  int end() const { return corner | 1 << axis; }
};

class Slicer {
 public:
  Slicer(const SlicePlanes& planes, SliceList& result) : planes_(planes), result_(result) {
    int flips = 0;
    for (int a = 0; a < 3; ++a) {
      flipped_[static_cast<size_t>(a)] = planes.normal[a] < 0;
      flips += planes.normal[a] < 0 ? 1 : 0;
      // An edge across the view is never active in two slices.
      delta_[a] = planes.normal[a] == 0 ? 0 : planes.step / planes.normal[a];
    }
    connections_ = &kConnections[static_cast<size_t>(flips % 2)];
  }

  void slice(const SlicedBox& box) {
    begin(box);
    size_t event = 0;
    // Slices before the view's first are skipped whole: no intersection has a position yet, thus
    // place() computes all of them at slice k.
    int64_t k = std::max(planes_.first_slice, events_[0].slice);
    while (k < events_[7].slice) {
      // Several corners may lie between two slices. All are passed before a position is computed,
      // so that edges shorter than a step, which no slice meets, cost no arithmetic.
      while (events_[event].slice <= k) pass(events_[event++].corner);
      place(k);
      const int64_t until = events_[event].slice;
      emit(k++);
      // No corner lies before slice `until`: the polygon keeps its edges, and each vertex moves by
      // a constant (Li 2003, section 3.3).
      for (; k < until; ++k) {
        advance();
        emit(k);
      }
    }
  }

 private:
  struct Event {
    double depth = 0;
    int64_t slice = 0;  // the first that has passed the corner
    int corner = 0;
  };

  // The corners in the order in which they are passed.
  void begin(const SlicedBox& box) {
    box_ = &box;
    delta_texture_ = delta_ * box.texture_scale;
    count_ = 0;
    for (int corner = 0; corner < 8; ++corner) {
      Vec3d& at = corners_[static_cast<size_t>(corner)];
      for (int a = 0; a < 3; ++a) {
        const bool far = (corner >> a & 1) != 0;
        at[a] = far != flipped_[static_cast<size_t>(a)] ? box.hi[a] : box.lo[a];
      }
      const double depth = planes_.depthOf(at);
      events_[static_cast<size_t>(corner)] = {depth, firstSliceAt(depth), corner};
    }
    // An insertion sort: 0 and 7 are in place, and of equals the one with fewer bits comes first,
    // as it must.
    for (size_t i = 2; i < 7; ++i)
      for (size_t j = i; j > 1 && events_[j].depth < events_[j - 1].depth; --j)
        std::swap(events_[j], events_[j - 1]);
  }

  int64_t firstSliceAt(double depth) const {
    auto k = static_cast<int64_t>(std::ceil((depth - planes_.first) / planes_.step - 0.5));
    // The division may round across the comparison that decides.
    while (planes_.depthOfSlice(k) < depth) ++k;
    while (planes_.depthOfSlice(k - 1) >= depth) --k;
    return k;
  }

  // The slice has moved beyond a corner: intersections that end there give way to those that begin
  // there, in place.
  void pass(int corner) {
    // No intersection ends at the corner nearest to the eye. The first polygon goes to the end of
    // the list, which is empty.
    size_t at = count_;
    for (size_t i = count_; i-- > 0;) {
      if (active_[i].end() != corner) continue;
      // If two neighbours end here, the second goes, even if the list's end lies between them.
      if (at < count_) remove(at);
      at = i;
    }
    const Connection& next = (*connections_)[static_cast<size_t>(corner)];
    if (corner != 0) remove(at);
    for (int i = 0; i < next.count; ++i)
      insert(at + static_cast<size_t>(i), corner, next.axes[static_cast<size_t>(i)]);
  }

  void remove(size_t at) {
    --count_;
    for (size_t i = at; i < count_; ++i) active_[i] = active_[i + 1];
  }
  void insert(size_t at, int corner, int axis) {
    for (size_t i = count_; i > at; --i) active_[i] = active_[i - 1];
    active_[at].corner = corner;
    active_[at].axis = axis;
    active_[at].fresh = true;
    ++count_;
  }

  // Moves the intersections on to slice k, and computes those that have begun since the last one.
  void place(int64_t k) {
    const double depth = planes_.depthOfSlice(k);
    for (size_t i = 0; i < count_; ++i) {
      Intersection& vertex = active_[i];
      const int a = vertex.axis;
      if (!vertex.fresh) {
        vertex.position[a] += delta_[a];
        vertex.texture[a] += delta_texture_[a];
        continue;
      }
      const Vec3d& from = corners_[static_cast<size_t>(vertex.corner)];
      vertex.fresh = false;
      vertex.position = from;
      // Rounding might place a vertex just outside the box.
      vertex.position[a] = std::clamp(from[a] + (depth - planes_.depthOf(from)) / planes_.normal[a],
                                      box_->lo[a], box_->hi[a]);
      vertex.texture = vertex.position * box_->texture_scale + box_->texture_offset;
    }
  }
  void advance() {
    for (size_t i = 0; i < count_; ++i) {
      const int a = active_[i].axis;
      active_[i].position[a] += delta_[a];
      active_[i].texture[a] += delta_texture_[a];
    }
  }

  void emit(int64_t k) {
    const size_t first = result_.vertices.size();
    result_.polygons.push_back({k, static_cast<uint32_t>(first), static_cast<uint32_t>(count_)});
    result_.vertices.resize(first + count_);
    SliceVertex* to = result_.vertices.data() + first;
    for (size_t i = 0; i < count_; ++i, ++to) {
      const auto& [position, texture, corner, axis, fresh] = active_[i];
      to->position = {static_cast<float>(position.x), static_cast<float>(position.y),
                      static_cast<float>(position.z)};
      to->texture = {static_cast<float>(texture.x), static_cast<float>(texture.y),
                     static_cast<float>(texture.z)};
    }
  }

  const SlicePlanes& planes_;
  SliceList& result_;
  // Set for each view.
  std::array<bool, 3> flipped_{};
  const std::array<Connection, 8>* connections_ = nullptr;
  Vec3d delta_;
  // Set for each box.
  const SlicedBox* box_ = nullptr;
  Vec3d delta_texture_;
  std::array<Vec3d, 8> corners_;
  std::array<Event, 8> events_;
  std::array<Intersection, 8> active_;
  size_t count_ = 0;
};

}  // namespace

void sliceIncrementally(const SlicePlanes& planes, std::span<const SlicedBox> boxes,
                        SliceList& result) {
  Slicer slicer(planes, result);
  for (const SlicedBox& box : boxes) slicer.slice(box);
}

}  // namespace sluice

// The incremental slicer (Li 2003, section 3.3): boxes are cut by the view's slices, each slice's
// polygon from the one before.
//
// A polygon's vertices lie on edges of the box, and from slice to slice a vertex moves along its
// edge by a constant with a single non-zero element; so do its texture coordinates. The list of
// active intersections only changes where a slice passes a corner: the intersections on the edges
// that end there give way, in place, to those on the edges that begin there. Which these are, and
// in which order, is the same for all boxes (the connection list), seen from the nearest corner.
//
// The paper finds passed corners by testing each vertex in each slice. Corners are known in advance
// here, so a slice between two corners costs an addition a vertex. Deciding by corners also makes
// degenerate cuts exact: a corner is passed or not by the rule of slices.h, whatever the vertices
// have been rounded to. Pure function, any thread.
#pragma once

#include <span>

#include "src/slicing/slices.h"

namespace sluice {

// Appends the polygons of all slices that cut each box: the same as plain_slicer.h, vertex for
// vertex, though they may begin at another vertex.
void sliceIncrementally(const SlicePlanes& planes, std::span<const SlicedBox> boxes,
                        SliceList& result);

}  // namespace sluice

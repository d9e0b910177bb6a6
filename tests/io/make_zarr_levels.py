"""Writes OME-Zarr images of several levels with zarr-python, as different programs make them.

make_zarr_levels.py FOLDER: for each case an image FOLDER/<case>, and in FOLDER/cases.txt a line
"<case> <levels that can be used> <note>" followed, for each level but the first, by the finest voxels
per voxel of it along x, y, z and the place of its first voxel among them. <note> is a word that one
of the notes must have, "-" where there must be none.
"""

import os
import sys

import numpy as np
import zarr

root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")


def scene(shape):
    """Waves of several lengths, smooth enough for a mean and rough enough to tell places apart."""
    z, y, x = np.indices(shape) + 0.0
    return 128 + 40 * np.sin(x / 3.1 + 0.4 * z) + 40 * np.cos(y / 4.3) + 30 * np.sin((x + y + z) / 2.3)


def mean(voxels, factors, whole_blocks=False):
    """Means of blocks; those at the upper ends may have fewer voxels, or are left out."""
    for axis, factor in enumerate(factors):
        size = voxels.shape[axis]
        if whole_blocks:
            voxels = voxels.take(range(size // factor * factor), axis)
        starts = np.arange(0, voxels.shape[axis], factor)
        counts = np.diff(np.append(starts, voxels.shape[axis]))
        shape = [1, 1, 1]
        shape[axis] = -1
        voxels = np.add.reduceat(voxels, starts, axis) / counts.reshape(shape)
    return voxels


def strided(voxels, factors):
    return voxels[::factors[0], ::factors[1], ::factors[2]]


def image(name, levels, scales, translations=None, places=None, note="-", kinds=None, paths=None, leave_out=(), usable=None):
    """`levels`: voxels; `scales` None: no transformations at all. All orders are z, y, x."""
    group = zarr.open_group(os.path.join(root, name), "w")
    datasets = []
    for i, voxels in enumerate(levels):
        path = paths[i] if paths else str(i)
        if i not in leave_out:
            kind = kinds[i] if kinds else "<f4"
            group.array(path, np.asarray(voxels).astype(kind), chunks=(16, 16, 16), dimension_separator="/")
        dataset = {"path": path}
        if scales:
            dataset["coordinateTransformations"] = [{"type": "scale", "scale": list(map(float, scales[i]))}]
            if translations:
                dataset["coordinateTransformations"].append({"type": "translation", "translation": list(map(float, translations[i]))})
        datasets.append(dataset)
    group.attrs["multiscales"] = [{"version": "0.4", "axes": [{"name": a, "type": "space"} for a in "zyx"], "datasets": datasets}]
    line = f"{name} {usable or len(levels)} {note}"
    for factor, offset in places:
        line += "".join(f" {v}" for v in (*factor[::-1], *offset[::-1]))
    cases.write(line + "\n")


def pyramid(voxels, steps, make, **options):
    """Each level from level 0, by the product of the steps; and its factors."""
    factors = [np.ones(3, int)]
    for step in steps:
        factors.append(factors[-1] * np.asarray(step))
    return [voxels] + [make(voxels, f, **options) for f in factors[1:]], factors


def corner(factors):
    return [(f, (f - 1) / 2) for f in factors[1:]]


def centre(factors):
    return [(f, (0, 0, 0)) for f in factors[1:]]


even = scene((48, 64, 80))
levels, factors = pyramid(even, [(2, 2, 2)] * 2, mean)
image("translated", levels, factors, [(f - 1) / 2 for f in factors], corner(factors))
image("translated-away", levels, [3 * f for f in factors], [100 + 3 * (f - 1) / 2 for f in factors], corner(factors))
image("scale-mean", levels, factors, None, corner(factors), note="corner")
image("no-scale", levels, None, None, corner(factors), note="corner")
image("levels-out-of-order", [levels[0], levels[2], levels[1]], [factors[i] for i in (0, 2, 1)], None, corner(factors), note="corner")
image("folders", levels, factors, None, corner(factors), note="corner", paths=["full", "half/a", "quarter/b"])
levels, factors = pyramid(even, [(2, 2, 2)] * 2, strided)
image("scale-strided", levels, factors, None, centre(factors), note="centre")
image("translated-strided", levels, factors, [(5, 6, 7)] * 3, centre(factors))
levels, factors = pyramid(even, [(3, 3, 3)] * 2, mean)
image("factor-3", levels, factors, None, corner(factors), note="corner")
levels, factors = pyramid(even, [(1, 2, 2), (1, 2, 2), (2, 2, 2)], mean)
image("anisotropic", levels, [f * (4, 1, 1) for f in factors], None, corner(factors), note="corner")
odd = scene((47, 61, 83))
for name, options in (("odd-rounded-up", {}), ("odd-rounded-down", {"whole_blocks": True})):
    levels, factors = pyramid(odd, [(2, 2, 2)] * 2, mean, **options)
    image(name, levels, factors, None, corner(factors), note="corner")
levels, factors = pyramid(odd, [(2, 2, 2)] * 2, strided)
image("odd-strided", levels, factors, None, centre(factors), note="centre")
levels, factors = pyramid(odd, [(3, 3, 3)], strided)
image("factor-3-strided", levels, factors, None, centre(factors), note="centre")
levels, factors = pyramid(even, [(1, 2, 2), (1, 2, 2)], strided)
image("anisotropic-strided", levels, [f * (4, 1, 1) for f in factors], None, centre(factors), note="centre")
levels, factors = pyramid(odd, [(1, 3, 2), (3, 1, 2)], mean)
spacing = np.array([2.5, 0.4, 0.7])
image("odd-anisotropic-moved", levels, [f * spacing for f in factors], [np.array([7, -3, 2]) + (f - 1) / 2 * spacing for f in factors], corner(factors))
flat = np.full((32, 32, 32), 7.0)
levels, factors = pyramid(flat, [(2, 2, 2)], mean)
image("flat", levels, factors, None, corner(factors), note="assumes")

# What does not fit is left out, by name.
levels, factors = pyramid(even, [(2, 2, 2)] * 2, mean)
place = [(f - 1) / 2 for f in factors]
image("missing-level", levels, factors, place, corner(factors)[1:], note="1/.zarray", leave_out=(1,), usable=2)
image("superfluous-level", levels + [levels[0]], factors + [factors[0]], place + [place[0]], corner(factors), note="fine", usable=3)
image("wrong-scale", levels, [factors[0], 4 * factors[1], factors[2]], place, corner(factors)[1:], note="shape", usable=2)
image("other-type", levels, factors, place, corner(factors)[1:], note="voxels", kinds=["<f4", "<u2", "<f4"], usable=2)
image("finer", [levels[1], levels[0], levels[2]], [factors[1], factors[0], factors[2]], [place[1], place[0], place[2]],
      [((2, 2, 2), (0.5, 0.5, 0.5))], note="finer", usable=2)

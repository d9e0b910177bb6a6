"""Compares the levels of stores with what NumPy makes of their level 0.

check_packed_levels.py STORE mean|max|min|mode [STORE ...]: every voxel of a level is compared with that of its block, a
level's place with its scale. Levels of means have spreads: twice NumPy's standard deviation; levels of modes have
shares: the part of a block that is not its mode. Several words with
commas between: the further levels lie in groups of their own, which the attributes name. Prints "level shape step"
a line for each level, x first.
"""

import sys

import numpy as np
import zarr


def place(dataset):
    scale, translation = dataset["coordinateTransformations"]
    assert scale["type"] == "scale" and translation["type"] == "translation"
    return np.array(scale["scale"]), np.array(translation["translation"])


def mode(block):
    values, counts = np.unique(block, return_counts=True)
    return values[np.argmax(counts)]


def others(block):
    values, counts = np.unique(block, return_counts=True)
    return 1 - counts.max() / block.size


def blocks(voxels, step, make, dtype=None):
    """Of a volume; blocks at the upper ends may have fewer voxels."""
    out = np.empty([-(-n // s) for n, s in zip(voxels.shape, step)], dtype or voxels.dtype)
    for index in np.ndindex(out.shape):
        out[index] = make(voxels[tuple(slice(i * s, (i + 1) * s) for i, s in zip(index, step))])
    return out


def mean(voxels, step):
    sums = voxels.astype("f8")
    for axis, s in enumerate(step):
        starts = np.arange(0, sums.shape[axis], s)
        counts = np.diff(np.append(starts, sums.shape[axis])).reshape([-1 if a == axis else 1 for a in range(3)])
        sums = np.add.reduceat(sums, starts, axis) / counts
    return sums


def extreme(voxels, step, of):
    for axis, s in enumerate(step):
        voxels = of.reduceat(voxels, np.arange(0, voxels.shape[axis], s), axis)
    return voxels


def spread(voxels, step):
    """Through the mean first, so that nothing is cancelled."""
    values = voxels.astype("f8")
    means = mean(values, step)
    for axis, s in enumerate(step):
        means = np.repeat(means, s, axis).take(range(values.shape[axis]), axis)
    return 2 * np.sqrt(mean((values - means) ** 2, step))


def check(store, words):
    group = zarr.open(store, "r")
    how, *further = words.split(",")
    image = group.attrs["multiscales"][0]
    fine = group["0"][:]
    space = fine.ndim - 3
    own = group.attrs["sluice"] if "sluice" in group.attrs else {}
    spreads = own.get("spreads")
    folders = own.get("levels", {})
    assert sorted(folders) == sorted(further), folders
    assert (spreads is not None) == (how in ("mean", "mode"))
    assert image["type"] == how
    extremes = {"max": np.maximum, "min": np.minimum}
    kinds = {"u1": "u1", "i1": "u1", "u2": "u2", "i2": "u2"}
    scale_0, translation_0 = place(image["datasets"][0])
    for i, dataset in enumerate(image["datasets"][1:], 1):
        scale, translation = place(dataset)
        step = np.rint(scale / scale_0).astype(int)
        assert np.allclose(scale, step * scale_0)
        assert np.allclose(translation, translation_0 + (step - 1) / 2 * scale_0), (translation, translation_0)
        assert (step[:space] == 1).all()
        coarse = group[dataset["path"]][:]
        for kind in further:
            made = group[f"{folders[kind]}/{dataset['path']}"][:]
            for outer in np.ndindex(fine.shape[:space]):
                voxels = fine[outer]
                assert np.array_equal(made[outer], extreme(voxels, step[space:], extremes[kind]) if kind in extremes else blocks(voxels, step[space:], mode))
        for outer in np.ndindex(fine.shape[:space]):
            voxels, found = fine[outer], coarse[outer]
            if how == "mean":
                expected = mean(voxels, step[space:])
                tolerance = 0.5 + 1e-9 if found.dtype.kind in "iu" else 1e-6 * max(1, np.abs(expected).max())
                assert found.shape == expected.shape, (found.shape, expected.shape)
                assert np.abs(found.astype("f8") - expected).max() <= tolerance
                kept = group[f"{spreads}/{dataset['path']}"][outer]
                assert kept.dtype == kinds.get(fine.dtype.str[1:], "f4"), kept.dtype
                expected = spread(voxels, step[space:])
                tolerance = 0.5 + 1e-9 if kept.dtype.kind == "u" else 1e-6 * max(1, expected.max())
                assert kept.shape == expected.shape
                assert np.abs(kept.astype("f8") - expected).max() <= tolerance
            else:
                expected = extreme(voxels, step[space:], extremes[how]) if how in extremes else blocks(voxels, step[space:], mode)
                assert np.array_equal(found, expected)
            if how == "mode":
                kept = group[f"{spreads}/{dataset['path']}"][outer]
                assert kept.dtype == kinds.get(fine.dtype.str[1:], "f4"), kept.dtype
                whole = np.iinfo(kept.dtype).max if kept.dtype.kind == "u" else 1
                expected = whole * blocks(voxels, step[space:], others, "f8")
                assert expected.max() > 0 and kept.shape == expected.shape
                assert np.abs(kept - expected).max() <= (0.5 + 1e-9 if whole > 1 else 1e-6)
        print(i, *coarse.shape[:space - 1 if space else None:-1], *step[:space - 1 if space else None:-1])


for store, words in zip(sys.argv[1::2], sys.argv[2::2]):
    try:
        check(store, words)
    except AssertionError:
        print(f"{store} {words}:", file=sys.stderr)
        raise

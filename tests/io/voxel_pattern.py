"""Voxels for the stores of make_zarr.py and make_zarr3.py."""

import numpy as np


def voxels_of(rng, kind, shape, hole=None):
    """Smooth in part, noisy in part, and `hole` in one corner. `kind`: a NumPy type."""
    values = sum(i * f for i, f in zip(np.indices(shape)[::-1], (1, 3, 31, 7, 11))) % 97
    values = values + (rng.random(shape) < 0.2) * 3
    if np.dtype(kind).kind == "b":
        values = values % 2
    if np.dtype(kind).kind == "f":
        values = values / 7 - 3
    if hole is not None:
        values[..., : shape[-2] // 2 + 1, :] = hole
    return values.astype(kind)

"""Writes N5 data sets and groups, each beside the voxels it must be read as.

make_n5.py FOLDER: as make_zarr.py. zarr-python's N5Store writes whole blocks; blocks that are cut at the upper ends, as
N5's own library writes them, are written here and read back by N5Store first.
"""

import itertools
import json
import os
import struct
import sys
import warnings

import numcodecs
import numpy as np
import zarr

sys.dont_write_bytecode = True
warnings.filterwarnings("ignore")
from voxel_pattern import voxels_of

NAMES = {"uint8": "u8", "int8": "i8", "uint16": "u16", "int16": "i16", "uint32": "u32", "int32": "i32", "float32": "f32", "float64": "f64"}
rng = np.random.default_rng(5)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")
SHAPE = (11, 13, 17)


def says(name, values, seen=None, steps=1, channel=-1, missing=False):
    """`values` in the order t, z, y, x."""
    seen = values if seen is None else seen
    np.ascontiguousarray(seen).tofile(os.path.join(root, name) + ".bin")
    cases.write(f"{name} {NAMES[values.dtype.name]} {seen.shape[-1]} {seen.shape[-2]} {seen.shape[-3]} {steps} {channel} {int(missing)}\n")


def by_store(name, kind, chunks, compressor, shape=SHAPE, hole=None):
    values = voxels_of(rng, kind, shape, hole)
    array = zarr.open(zarr.N5Store(os.path.join(root, name)), mode="w", shape=shape, chunks=chunks, dtype=kind, compressor=compressor,
                      write_empty_chunks=hole is None)
    array[...] = values
    return values


PACKERS = {"raw": (None, {"type": "raw"}), "gzip": (numcodecs.GZip(5), {"type": "gzip", "level": 5, "useZlib": False}),
           "zlib": (numcodecs.Zlib(5), {"type": "gzip", "level": 5, "useZlib": True}), "zstd": (numcodecs.Zstd(3), {"type": "zstd", "level": 3}),
           "xz": (numcodecs.LZMA(preset=6), {"type": "xz", "preset": 6}), "blosc": (numcodecs.Blosc("lz4", 5, 1), {"type": "blosc", "cname": "lz4", "clevel": 5, "shuffle": 1, "blocksize": 0})}


def by_hand(folder, values, chunks, packer="gzip", mode=0, leave_out=(), **more):
    """Axes as NumPy has them, the slowest first."""
    os.makedirs(folder)
    codec, said = PACKERS[packer]
    with open(os.path.join(folder, "attributes.json"), "w") as file:
        json.dump({"dimensions": values.shape[::-1], "blockSize": chunks[::-1], "dataType": values.dtype.name, "compression": said, "n5": "2.5.0", **more}, file)
    for index in itertools.product(*(range(-(-n // c)) for n, c in zip(values.shape, chunks))):
        if index in leave_out:
            values[tuple(slice(i * c, (i + 1) * c) for i, c in zip(index, chunks))] = 0
            continue
        part = values[tuple(slice(i * c, (i + 1) * c) for i, c in zip(index, chunks))]
        data = np.ascontiguousarray(part).astype(part.dtype.newbyteorder(">")).tobytes()
        header = struct.pack(f">HH{part.ndim}I", mode, part.ndim, *part.shape[::-1]) + (struct.pack(">I", part.size) if mode == 1 else b"")
        path = os.path.join(folder, *(str(i) for i in index[::-1]))
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(header + (bytes(codec.encode(data)) if codec else data))
    if packer != "zlib" and mode == 0:  # N5Store takes its own words for the compression
        seen = zarr.open(zarr.N5Store(folder), mode="r")[...] if packer not in ("zstd", "xz") else values
        assert np.array_equal(seen, values), folder


for kind in NAMES:
    says(f"store_{kind}", by_store(f"store_{kind}", kind, (4, 5, 6), numcodecs.GZip(1)))
    values = voxels_of(rng, kind, SHAPE)
    by_hand(os.path.join(root, f"cut_{kind}"), values, (4, 5, 6), "raw")
    says(f"cut_{kind}", values)
for name, compressor in (("none", None), ("zlib", numcodecs.Zlib(3)), ("gzip", numcodecs.GZip(3)), ("blosc", numcodecs.Blosc("zstd", 3, 1))):
    says(f"store_{name}", by_store(f"store_{name}", "uint16", (8, 5, 12), compressor))
says("store_hole", by_store("store_hole", "uint16", (2, 3, 4), numcodecs.GZip(1), hole=0), missing=True)
for packer, mode in itertools.product(PACKERS, (0, 1)):
    values = voxels_of(rng, "int16", SHAPE)
    by_hand(os.path.join(root, f"{packer}_{mode}"), values, (4, 13, 6), packer, mode)
    says(f"{packer}_{mode}", values)
values = voxels_of(rng, "uint8", SHAPE)
by_hand(os.path.join(root, "left_out"), values, (4, 5, 6), leave_out=((0, 0, 0), (2, 2, 2), (1, 0, 2)))
says("left_out", values, missing=True)
values = voxels_of(rng, "uint8", (3, 9, 10, 11))
by_hand(os.path.join(root, "steps"), values, (2, 4, 4, 4))
says("steps", values, steps=3)
values = voxels_of(rng, "uint16", (2, 9, 2, 10, 11))  # t z c y x
for channel in (0, 1):
    by_hand(os.path.join(root, f"channels_{channel}"), values, (1, 4, 1, 4, 5), axes=["x", "y", "c", "z", "t"], pixelResolution=[0.5, 0.25, 1, 2, 1])
    says(f"channels_{channel}", values, values[:, :, channel], 2, channel)


def pyramid(name, group, own):
    """Means of 2 x 2 x 1 and 4 x 4 x 2 voxels. `own`: attributes of a level by its factors."""
    finest = voxels_of(rng, "uint16", (8, 24, 32))
    factors = ([1, 1, 1], [2, 2, 1], [4, 4, 2])
    for i, (x, y, z) in enumerate(factors):
        level = finest.reshape(8 // z, z, 24 // y, y, 32 // x, x).mean(axis=(1, 3, 5)).astype("uint16")
        by_hand(os.path.join(root, name, f"s{i}"), level, (4, 8, 8), **own([x, y, z]))
        level.tofile(os.path.join(root, f"{name}_{i}.bin"))
    if group is not None:
        with open(os.path.join(root, name, "attributes.json"), "w") as file:
            json.dump(group, file)
    says(name, finest)


ALL = [[1, 1, 1], [2, 2, 1], [4, 4, 2]]
pyramid("own_factors", {"axes": ["x", "y", "z"], "units": ["um", "um", "um"], "resolution": [0.5, 0.5, 2]}, lambda f: {"downsamplingFactors": f})
pyramid("scales", {"scales": ALL, "pixelResolution": {"unit": "um", "dimensions": [0.5, 0.5, 2]}}, lambda f: {})
pyramid("group_factors", {"downsamplingFactors": ALL, "resolution": [0.5, 0.5, 2], "units": "um"}, lambda f: {})
pyramid("transforms", {}, lambda f: {"transform": {
    "axes": ["z", "y", "x"], "units": ["um", "um", "um"], "scale": [2.0 * f[2], 0.5 * f[1], 0.5 * f[0]],
    "translate": [f[2] - 1, 0.25 * (f[1] - 1), 0.25 * (f[0] - 1)]}})
pyramid("no_factors", {"resolution": [0.5, 0.5, 2], "units": "um"}, lambda f: {})
pyramid("no_group", None, lambda f: {"downsamplingFactors": f, "pixelResolution": {"unit": "um", "dimensions": [0.5, 0.5, 2]}})

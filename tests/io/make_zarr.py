"""Writes Zarr v2 stores with zarr-python, each beside the voxels it must be read as.

make_zarr.py FOLDER: for each case a store FOLDER/<case>, the voxels in FOLDER/<case>.bin (x
fastest, time step after time step, this machine's byte order), and in FOLDER/cases.txt a line
"<case> <type> <x> <y> <z> <time steps> <channel or -1> <missing chunks: 0 or 1>".
"""

import os
import sys

import numcodecs
import numpy as np
import zarr

sys.dont_write_bytecode = True
from voxel_pattern import voxels_of

NAMES = {"b1": "u8", "u1": "u8", "i1": "i8", "u2": "u16", "i2": "i16", "u4": "u32", "i4": "i32", "f4": "f32", "f8": "f64"}
rng = np.random.default_rng(5)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")


def case(name, kind, shape, chunks, codec, separator=".", order="C", fill=0, axes="zyx", attrs=None, channel=-1, hole=None, array="", sparse=False):
    stored = voxels_of(rng, kind[-2:], shape, hole)
    path = os.path.join(root, name)
    store = zarr.DirectoryStore(path) if separator == "." else zarr.NestedDirectoryStore(path)
    group_path = array or None
    if array:
        zarr.group(store=store, overwrite=True).attrs.update(attrs or {})
    out = zarr.create(shape=shape, chunks=chunks, dtype=kind, compressor=codec, order=order, fill_value=fill, store=store,
                      path=group_path, dimension_separator=separator, write_empty_chunks=not sparse, overwrite=True)
    if not array and attrs:
        out.attrs.update(attrs)
    out[...] = stored
    seen = stored
    axes = list(axes)
    if "c" in axes:
        seen = np.take(seen, max(channel, 0), axis=axes.index("c"))
        axes.remove("c")
    seen = np.transpose(seen, [axes.index(a) for a in ("tzyx" if "t" in axes else "zyx")])
    steps = seen.shape[0] if "t" in axes else 1
    np.ascontiguousarray(seen).astype(seen.dtype.newbyteorder("=")).tofile(path + ".bin")
    missing = out.nchunks_initialized < out.nchunks
    assert missing == (sparse and hole is not None), name
    cases.write(f"{name} {NAMES[kind[-2:]]} {seen.shape[-1]} {seen.shape[-2]} {seen.shape[-3]} {steps} {channel} {int(missing)}\n")


def ome(axes, scale=None, version="0.4", **more):
    kinds = {"t": "time", "c": "channel"}
    level = {"path": "0"}
    if scale:
        level["coordinateTransformations"] = [{"type": "scale", "scale": scale}]
    multiscale = {"version": version, "datasets": [level], **more}
    if version == "0.4":
        multiscale["axes"] = [{"name": a, "type": kinds.get(a, "space")} for a in axes]
    if version == "0.3":
        multiscale["axes"] = list(axes)
    return {"multiscales": [multiscale]}


SHAPE, CHUNKS = (13, 21, 30), (8, 8, 8)
CODECS = {"none": None, "zlib": numcodecs.Zlib(4), "gzip": numcodecs.GZip(3), "zstd": numcodecs.Zstd(2)}
for inside in ("lz4", "lz4hc", "zstd", "zlib", "blosclz"):
    for shuffle in (0, 1, 2):
        CODECS[f"blosc-{inside}-{shuffle}"] = numcodecs.Blosc(inside, 3, shuffle)
for codec in CODECS:
    for separator in (".", "/"):
        kind = separator == "." and "<u2" or "<f4"
        case(f"{codec}-{'dot' if separator == '.' else 'slash'}", kind, SHAPE, CHUNKS, CODECS[codec], separator)
for kind in ("|b1", "|u1", "|i1", "<u2", ">u2", "<i2", ">i2", "<u4", ">u4", "<i4", ">i4", "<f4", ">f4", "<f8", ">f8"):
    order = kind.replace("<", "little-").replace(">", "big-").replace("|", "")
    case("type-" + order, kind, SHAPE, CHUNKS, numcodecs.Blosc("lz4", 5, 1), "/")
for separator in (".", "/"):
    mark = "dot" if separator == "." else "slash"
    for kind, fill in (("|u1", 7), ("<i2", -5), (">f4", 2.5), ("<f8", float("nan")), ("<f4", float("-inf"))):
        case(f"missing-{mark}-{kind[1:]}-{fill}", kind, SHAPE, CHUNKS, numcodecs.Zlib(1), separator, fill=fill, hole=fill, sparse=True)
case("missing-null-fill", "|u1", SHAPE, CHUNKS, numcodecs.Zlib(1), fill=None)
case("order-f", "<u2", SHAPE, CHUNKS, numcodecs.Zstd(1), "/", order="F")
case("order-f-5d", "<i4", (2, 2, 5, 9, 7), (1, 2, 4, 4, 4), None, order="F", axes="tczyx", channel=1)
case("chunk-larger", "<u2", SHAPE, (64, 64, 64), numcodecs.Zlib(1))
case("chunk-whole", "<u2", SHAPE, SHAPE, None)
case("chunk-odd", "|u1", SHAPE, (1, 21, 7), numcodecs.GZip(1), "/")
case("plain-4d", "|u1", (3, *SHAPE), (2, *CHUNKS), numcodecs.Zstd(3), axes="tzyx")
case("plain-4d-channel", "|u1", (3, *SHAPE), (2, *CHUNKS), numcodecs.Zstd(3), axes="czyx", channel=2)
case("plain-5d", "<u2", (2, 3, 5, 9, 7), (1, 1, 4, 4, 4), numcodecs.Zlib(1), "/", axes="tczyx")
case("plain-5d-channel", "<u2", (2, 3, 5, 9, 7), (2, 2, 4, 4, 4), numcodecs.Zlib(1), "/", axes="tczyx", channel=2)
case("xarray", "<u2", (2, 5, 9, 7), (1, 4, 4, 4), None, axes="czyx", channel=1, attrs={"_ARRAY_DIMENSIONS": ["channel", "z", "y", "x"]})
case("ome-3d", "|u1", SHAPE, CHUNKS, numcodecs.Blosc("zstd", 3, 2), "/", array="0", attrs=ome("zyx", [2.0, 0.5, 0.25]))
case("ome-4d", "<u2", (2, *SHAPE), (1, *CHUNKS), numcodecs.Blosc(), "/", array="0", axes="czyx", channel=1, attrs=ome("czyx", [1, 2.0, 0.5, 0.25]))
case("ome-5d", "<u2", (2, 2, 5, 9, 7), (1, 1, 4, 4, 4), numcodecs.Blosc(), "/", array="0", axes="tczyx", channel=0, attrs=ome("tczyx", [1, 1, 2.0, 0.5, 0.25]))
case("ome-0.3", "<u2", (2, 5, 9, 7), (1, 4, 4, 4), numcodecs.Blosc(), "/", array="0", axes="tzyx", attrs=ome("tzyx", version="0.3"))
case("ome-0.1", "<u2", (1, 1, 5, 9, 7), (1, 1, 4, 4, 4), numcodecs.Blosc(), ".", array="0", axes="tczyx", attrs=ome("tczyx", version="0.1"))
case("ome-xyz", "<u2", (9, 7, 5), (4, 4, 4), numcodecs.Blosc(), "/", array="0", axes="xyz", attrs=ome("xyz"))
case("ome-sparse", "|u1", (2, 2, *SHAPE), (1, 1, *CHUNKS), numcodecs.Blosc(), "/", array="0", axes="tczyx", channel=1, attrs=ome("tczyx"), hole=0, sparse=True)

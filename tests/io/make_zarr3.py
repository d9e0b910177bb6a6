"""Writes Zarr v3 stores as the specification says, each beside the voxels it must be read as.

make_zarr3.py FOLDER: as make_zarr.py. The writer here is for tests alone, since Debian 12 has none;
codecs are numcodecs', the checksum is computed bit by bit.
"""

import itertools
import json
import os
import struct
import sys

import numcodecs
import numpy as np

sys.dont_write_bytecode = True
from voxel_pattern import voxels_of

NAMES = {"bool": "u8", "uint8": "u8", "int8": "i8", "uint16": "u16", "int16": "i16", "uint32": "u32", "int32": "i32",
         "float32": "f32", "float64": "f64"}
MISSING = 2**64 - 1
rng = np.random.default_rng(7)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return struct.pack("<I", crc ^ 0xFFFFFFFF)


assert crc32c(b"123456789") == struct.pack("<I", 0xE3069283)

COMPRESSORS = {
    "gzip": (numcodecs.GZip(5), {"level": 5}),
    "zstd": (numcodecs.Zstd(3), {"level": 3, "checksum": False}),
    "blosc": (numcodecs.Blosc("lz4", 5, numcodecs.Blosc.SHUFFLE), {"cname": "lz4", "clevel": 5, "shuffle": "shuffle", "typesize": 2, "blocksize": 0}),
    "numcodecs.zlib": (numcodecs.Zlib(4), {"level": 4}),
}


class Codecs:
    """transpose, bytes, a compressor, crc32c."""

    def __init__(self, order=None, endian="little", compressor=None, crc=False):
        self.order, self.endian, self.compressor, self.crc = order, endian, compressor, crc

    def listed(self):
        found = [{"name": "transpose", "configuration": {"order": self.order}}] if self.order else []
        found.append({"name": "bytes", "configuration": {"endian": self.endian}} if self.endian else {"name": "bytes"})
        if self.compressor:
            found.append({"name": self.compressor, "configuration": COMPRESSORS[self.compressor][1]})
        return found + ([{"name": "crc32c"}] if self.crc else [])

    def encode(self, chunk):
        if self.order:
            chunk = chunk.transpose(self.order)
        kind = chunk.dtype.newbyteorder(">" if self.endian == "big" else "<")
        data = np.ascontiguousarray(chunk).astype(kind).tobytes()
        if self.compressor:
            data = bytes(COMPRESSORS[self.compressor][0].encode(data))
        return data + crc32c(data) if self.crc else data


class Shards:
    """sharding_indexed around other codecs."""

    def __init__(self, inner, codecs, location="end", crc=True, endian="little", gap=0):
        self.inner, self.codecs, self.location, self.crc, self.endian, self.gap = inner, codecs, location, crc, endian, gap

    def listed(self):
        index = [{"name": "bytes", "configuration": {"endian": self.endian}}] + ([{"name": "crc32c"}] if self.crc else [])
        return [{"name": "sharding_indexed", "configuration": {
            "chunk_shape": list(self.inner), "codecs": self.codecs.listed(), "index_codecs": index, "index_location": self.location}}]

    def encode(self, shard, fill):
        counts = [n // i for n, i in zip(shard.shape, self.inner)]
        length = 16 * int(np.prod(counts)) + (4 if self.crc else 0)
        at = length if self.location == "start" else 0
        entries, body = {}, b""
        places = list(itertools.product(*(range(n) for n in counts)))
        for place in reversed(places):  # chunks may lie in any order
            part = shard[tuple(slice(p * i, (p + 1) * i) for p, i in zip(place, self.inner))]
            if np.array_equal(part, np.full_like(part, fill), equal_nan=part.dtype.kind == "f"):
                entries[place] = (MISSING, MISSING)
                continue
            data = self.codecs.encode(part)
            body += b"\0" * self.gap
            entries[place] = (at + len(body), len(data))
            body += data
        index = b"".join(struct.pack((">" if self.endian == "big" else "<") + "QQ", *entries[place]) for place in places)
        index += crc32c(index) if self.crc else b""
        return index + body if self.location == "start" else body + index


def write_array(path, values, chunks, codecs, fill=0, fill_text=None, keys=("default", "/"), **more):
    """Chunks of the fill value alone are left out. Returns whether any is."""
    os.makedirs(path)
    meta = {"zarr_format": 3, "node_type": "array", "shape": values.shape, "data_type": values.dtype.name,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunks}},
            "chunk_key_encoding": {"name": keys[0], "configuration": {"separator": keys[1]}},
            "fill_value": fill_text if fill_text is not None else fill, "codecs": codecs.listed(), **more}
    with open(os.path.join(path, "zarr.json"), "w") as file:
        json.dump(meta, file)
    missing = False
    for index in itertools.product(*(range(-(-n // c)) for n, c in zip(values.shape, chunks))):
        part = values[tuple(slice(i * c, (i + 1) * c) for i, c in zip(index, chunks))]
        chunk = np.full(chunks, fill, values.dtype)
        chunk[tuple(slice(n) for n in part.shape)] = part
        if np.array_equal(chunk, np.full_like(chunk, fill), equal_nan=values.dtype.kind == "f"):
            missing = True
            continue
        names = (["c"] if keys[0] == "default" else []) + [str(i) for i in index]
        name = os.path.join(path, keys[1].join(names))
        os.makedirs(os.path.dirname(name), exist_ok=True)
        with open(name, "wb") as file:
            file.write(codecs.encode(chunk, fill) if isinstance(codecs, Shards) else codecs.encode(chunk))
    return missing


def case(name, kind, shape, chunks, codecs, hole=None, axes="zyx", channel=-1, **more):
    values = voxels_of(rng, kind, shape, hole)
    missing = write_array(os.path.join(root, name), values, chunks, codecs, **more)
    seen, axes = values, list(axes)
    if "c" in axes:
        seen = np.take(seen, max(channel, 0), axis=axes.index("c"))
        axes.remove("c")
    seen = np.transpose(seen, [axes.index(a) for a in ("tzyx" if "t" in axes else "zyx")])
    np.ascontiguousarray(seen).tofile(os.path.join(root, name) + ".bin")
    steps = seen.shape[0] if "t" in axes else 1
    cases.write(f"{name} {NAMES[kind]} {seen.shape[-1]} {seen.shape[-2]} {seen.shape[-3]} {steps} {channel} {int(missing)}\n")


SHAPE = (11, 13, 17)
for kind in NAMES:
    case(f"plain_{kind}", kind, SHAPE, (4, 5, 6), Codecs())
    case(f"big_{kind}", kind, SHAPE, (4, 5, 6), Codecs(endian="big", compressor="zstd"))
    case(f"shard_{kind}", kind, SHAPE, (8, 8, 12), Shards((4, 4, 6), Codecs(compressor="zstd")))
for name in COMPRESSORS:
    for crc in (False, True):
        case(f"{name}_{crc}", "uint16", SHAPE, (4, 13, 6), Codecs(compressor=name, crc=crc))
        case(f"shard_{name}_{crc}", "uint16", SHAPE, (8, 8, 12), Shards((4, 4, 6), Codecs(compressor=name, crc=crc), gap=5))
case("crc", "int16", SHAPE, (4, 5, 6), Codecs(crc=True))
case("no_endian", "uint8", SHAPE, (4, 5, 6), Codecs(endian=None))
for location, crc, endian in itertools.product(("start", "end"), (False, True), ("little", "big")):
    case(f"index_{location}_{crc}_{endian}", "int32", SHAPE, (8, 12, 8), Shards((4, 4, 4), Codecs(crc=True), location, crc, endian))
case("one_shard", "uint8", SHAPE, (16, 16, 20), Shards((2, 4, 5), Codecs(compressor="blosc")))
for i, order in enumerate(itertools.permutations(range(3))):
    case(f"transposed_{i}", "uint16", SHAPE, (4, 5, 6), Codecs(order=list(order), compressor="gzip"))
    case(f"shard_transposed_{i}", "uint16", SHAPE, (8, 10, 12), Shards((4, 5, 6), Codecs(order=list(order))))
for separator in "./":
    for encoding in ("default", "v2"):
        named = {"/": "slash", ".": "dot"}[separator]
        case(f"keys_{encoding}_{named}", "uint8", SHAPE, (4, 5, 6), Codecs(), hole=7, fill=7, keys=(encoding, separator))
        case(f"shard_keys_{encoding}_{named}", "uint8", SHAPE, (4, 10, 12), Shards((4, 5, 6), Codecs()), hole=7, fill=7, keys=(encoding, separator))
case("nan", "float32", SHAPE, (4, 5, 6), Codecs(compressor="zstd"), hole=np.nan, fill=np.nan, fill_text="NaN")
case("nan_bits", "float64", SHAPE, (8, 5, 12), Shards((4, 5, 6), Codecs()), hole=np.nan, fill=np.nan, fill_text="0x7ff8000000000000")
case("steps", "uint8", (3, 9, 10, 11), (2, 8, 8, 8), Shards((1, 4, 4, 4), Codecs(compressor="zstd")), axes="tzyx")
for channel in (0, 1):
    case(f"channels_{channel}", "uint16", (2, 2, 9, 10, 11), (1, 2, 8, 8, 8), Shards((1, 1, 4, 4, 4), Codecs()), axes="tczyx", channel=channel)
case("named_axes", "uint8", (10, 11, 9), (4, 5, 6), Codecs(), axes="yxz", dimension_names=["y", "x", "z"])
case("unnamed_axes", "uint8", SHAPE, (4, 5, 6), Codecs(), dimension_names=[None, "y", "x"])
case("extension", "uint8", SHAPE, (4, 5, 6), Codecs(), made_by={"must_understand": False})


def image(name, version):
    """An OME-Zarr 0.5 image of two levels, each one folder deeper than usual."""
    fine = voxels_of(rng, "uint16", (8, 12, 16))
    coarse = fine.reshape(4, 2, 6, 2, 8, 2).mean(axis=(1, 3, 5)).astype("uint16")
    path = os.path.join(root, name)
    datasets = []
    for i, level in enumerate((fine, coarse)):
        write_array(os.path.join(path, f"scale{i}", "image"), level, (8, 8, 8), Shards((4, 4, 4), Codecs(compressor="zstd")),
                    dimension_names=["z", "y", "x"])
        step = 2.0**i
        datasets.append({"path": f"scale{i}/image", "coordinateTransformations": [
            {"type": "scale", "scale": [3 * step, step, step]},
            {"type": "translation", "translation": [1.5 * (step - 1), 0.5 * (step - 1), 0.5 * (step - 1)]}]})
    multiscale = {"axes": [{"name": a, "type": "space", "unit": "micrometer"} for a in "zyx"], "datasets": datasets}
    with open(os.path.join(path, "zarr.json"), "w") as file:
        json.dump({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {"version": version, "multiscales": [multiscale]}}}, file)
    fine.tofile(path + ".bin")
    coarse.tofile(path + "_coarse.bin")
    cases.write(f"{name} u16 16 12 8 1 -1 0\n")


image("image", "0.5")

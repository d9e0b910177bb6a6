"""Reads an array of a Zarr 3 store whose chunks lie in shards, made from the specification alone.

read_zarr3.py ARRAY OUT: decodes the codecs that sluice packs with (sharding_indexed around bytes, blosc and
crc32c, the index at the end with a crc32c), checks every checksum, and writes the voxels to OUT in C order.
Prints the number of files.
"""

import itertools
import json
import os
import struct
import sys

import numcodecs
import numpy as np


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def checked(data):
    assert struct.unpack("<I", data[-4:])[0] == crc32c(data[:-4]), "a checksum differs"
    return data[:-4]


root, out = sys.argv[1:]
meta = json.load(open(os.path.join(root, "zarr.json")))
assert meta["zarr_format"] == 3 and meta["node_type"] == "array"
# OME-Zarr 0.5 requires them.
assert meta["dimension_names"][-3:] == ["z", "y", "x"]
assert meta["chunk_key_encoding"] == {"name": "default", "configuration": {"separator": "/"}}
(sharding,) = meta["codecs"]
assert sharding["name"] == "sharding_indexed"
settings = sharding["configuration"]
assert [c["name"] for c in settings["codecs"]] == ["bytes", "blosc", "crc32c"]
assert [c["name"] for c in settings["index_codecs"]] == ["bytes", "crc32c"] and settings["index_location"] == "end"
kind = np.dtype(meta["data_type"])
assert settings["codecs"][1]["configuration"]["typesize"] == kind.itemsize
shape, shard, chunk = meta["shape"], meta["chunk_grid"]["configuration"]["chunk_shape"], settings["chunk_shape"]
voxels = np.full(shape, meta["fill_value"], kind)
grid = [s // c for s, c in zip(shard, chunk)]
files = 0
for at in itertools.product(*(range(-(-n // s)) for n, s in zip(shape, shard))):
    path = os.path.join(root, "c", *map(str, at))
    if not os.path.exists(path):
        continue
    files += 1
    data = open(path, "rb").read()
    index = checked(data[-16 * int(np.prod(grid)) - 4:])
    for i, inside in enumerate(itertools.product(*(range(n) for n in grid))):
        offset, length = struct.unpack_from("<QQ", index, 16 * i)
        if offset == length == 2**64 - 1:
            continue
        values = np.frombuffer(numcodecs.blosc.decompress(checked(data[offset:offset + length])), kind).reshape(chunk)
        place = tuple(slice(a * s + b * c, a * s + b * c + c) for a, s, b, c in zip(at, shard, inside, chunk))
        target = voxels[place]
        target[...] = values[tuple(slice(n) for n in target.shape)]
voxels.tofile(out)
print(files)

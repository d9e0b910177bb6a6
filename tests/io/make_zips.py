"""Writes Zarr stores into zip files, each beside the voxels it must be read as, as make_zarr.py does.

make_zips.py FOLDER: the zip files are those of zarr-python's ZipStore and of Python's zipfile.
"""

import os
import shutil
import struct
import sys
import warnings
import zipfile

import numpy as np
import zarr

sys.dont_write_bytecode = True
from voxel_pattern import voxels_of

rng = np.random.default_rng(7)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")
SHAPE = (11, 13, 17)


def case(name, voxels):
    voxels.tofile(os.path.join(root, name + ".bin"))
    cases.write(f"{name} u16 {voxels.shape[2]} {voxels.shape[1]} {voxels.shape[0]} 1 -1 0\n")


def stored(name, separator="/"):
    """A folder with a store, and its voxels."""
    voxels = voxels_of(rng, "u2", SHAPE, None)
    folder = os.path.join(root, name)
    store = zarr.NestedDirectoryStore(folder) if separator == "/" else zarr.DirectoryStore(folder)
    zarr.create(shape=SHAPE, chunks=(4, 5, 6), dtype="u2", compressor=None, store=store, dimension_separator=separator)[
        ...] = voxels
    return folder, voxels


def zipped(name, method, inside="", comment=b"", separator="/", folders=False, prefix="", others=()):
    folder, voxels = stored("of_" + name, separator)
    with zipfile.ZipFile(os.path.join(root, name), "w", method) as out:
        out.comment = comment
        for where, below, files in os.walk(folder):
            for each in sorted(files) + (sorted(below) if folders else []):
                path = os.path.join(where, each)
                as_name = os.path.join(inside, os.path.relpath(path, folder))
                if os.path.isdir(path):
                    out.write(path, as_name)
                else:
                    with open(path, "rb") as file:
                        out.writestr(zipfile.ZipInfo(prefix + as_name), file.read(), method)
        for other in others:
            out.writestr(other, "of no interest")
    shutil.rmtree(folder)
    case(name, voxels)


zipped("stored.zip", zipfile.ZIP_STORED)
zipped("deflated.zip", zipfile.ZIP_DEFLATED)
zipped("dotted.zip", zipfile.ZIP_STORED, separator=".")
zipped("comment.zip", zipfile.ZIP_STORED, comment=b"PK\5\6 is no end" * 40)
zipped("one_folder.zarr.zip", zipfile.ZIP_DEFLATED, inside="volume.zarr", folders=True)
zipped("named.ozx", zipfile.ZIP_STORED)
zipped("dot.zip", zipfile.ZIP_STORED, prefix="./")
zipped("mac.zip", zipfile.ZIP_DEFLATED, inside="outer/volume.zarr", others=("__MACOSX/outer/._volume.zarr", "README.txt"))

# The count of entries at the end in 16 bits, where it has more: here as if there were 65536 fewer.
zipped("counted.zip", zipfile.ZIP_STORED, others=[f"other/{i}" for i in range(65540)])
whole = bytearray(open(os.path.join(root, "counted.zip"), "rb").read())
end = whole.rfind(b"PK\5\6")
wide_end = whole.rfind(b"PK\6\6")
count, size, place = struct.unpack_from("<QQQ", whole, wide_end + 32)
with open(os.path.join(root, "counted.zip"), "wb") as out:
    out.write(whole[:wide_end] + struct.pack("<4sHHHHIIH", b"PK\5\6", 0, 0, count & 65535, count & 65535, size, place, 0))

# All numbers in 64 bits, as in zip files of more than 4 GiB.
limits = zipfile.ZIP64_LIMIT, zipfile.ZIP_FILECOUNT_LIMIT
zipfile.ZIP64_LIMIT, zipfile.ZIP_FILECOUNT_LIMIT = 10, 3
zipped("wide.zip", zipfile.ZIP_STORED)
zipfile.ZIP64_LIMIT, zipfile.ZIP_FILECOUNT_LIMIT = limits

# zarr-python's own; what is written twice is there twice, and the last one counts.
voxels = voxels_of(rng, "u2", SHAPE, None)
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    with zarr.ZipStore(os.path.join(root, "twice.zip"), mode="w") as store:
        array = zarr.create(shape=SHAPE, chunks=(4, 5, 6), dtype="u2", store=store)
        array[...] = 7
        array[...] = voxels
case("twice.zip", voxels)

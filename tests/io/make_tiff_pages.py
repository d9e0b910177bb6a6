"""Writes TIFF files whose descriptions say what their pages are, with tifffile, each beside its voxels.

make_tiff_pages.py FOLDER: for each case a file FOLDER/<case>.tif, the voxels of its last channel in
FOLDER/<case>.bin (x fastest, time step after time step, this machine's byte order), and in
FOLDER/cases.txt a line "<case> <x> <y> <z> <time steps> <channels> <spacing x, y, z> <unit>".
"""

import os
import sys

import numpy as np
import tifffile

rng = np.random.default_rng(3)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")


def case(name, tzcyx, spacing, unit):
    """`tzcyx`: the voxels in that order of axes. Returns the file to write."""
    t, z, c, y, x = tzcyx.shape
    np.ascontiguousarray(tzcyx[:, :, c - 1]).tofile(os.path.join(root, name + ".bin"))
    cases.write(f"{name} {x} {y} {z} {t} {c} {spacing[0]} {spacing[1]} {spacing[2]} {unit}\n")
    return os.path.join(root, name + ".tif")


def voxels(t, z, c, y=20, x=30):
    return rng.integers(0, 60000, (t, z, c, y, x)).astype("u2")


# ImageJ: pages in the order t z c, the pixels' size in the resolution tags.
def imagej(name, v, spacing, unit, said, **options):
    path = case(name, v, spacing, unit)
    tifffile.imwrite(path, v, imagej=True, resolution=(1 / spacing[0], 1 / spacing[1]),
                     metadata={"spacing": spacing[2], "unit": said, "axes": "TZCYX"}, **options)


imagej("imagej-stack", voxels(1, 7, 1), (0.5, 0.25, 2), "micrometer", "um")
imagej("imagej-micro-sign", voxels(1, 7, 1), (0.5, 0.5, 2), "micrometer", "\\u00B5m")
imagej("imagej-hyperstack", voxels(3, 4, 2), (0.5, 0.5, 1.5), "micrometer", "micron")
imagej("imagej-time", voxels(5, 1, 1), (2, 2, 1), "millimeter", "mm")
# As ImageJ writes stacks beyond 4 GiB: a table for the first page alone.
imagej("imagej-one-table", voxels(2, 5, 2), (1, 1, 3), "nanometer", "nm", truncate=True)


# OME: any order of pages, said in XML.
def ome(name, v, order, spacing, units, unit):
    path = case(name, v, spacing, unit)
    axes = {"T": 0, "Z": 1, "C": 2}
    slowest_first = order[::-1][:3]
    stored = np.transpose(v, [axes[a] for a in slowest_first] + [3, 4])
    metadata = {"axes": slowest_first + "YX"}
    for axis, size, said in zip("XYZ", spacing, units):
        metadata["PhysicalSize" + axis] = size * {"mm": 1e-3}.get(said, 1) if said == "mm" else size
        if said:
            metadata[f"PhysicalSize{axis}Unit"] = said
    if v.shape[2] > 1:
        metadata["Channel"] = {"Name": [f"stain {c}" for c in range(v.shape[2])]}
    tifffile.imwrite(path, stored, ome=True, photometric="minisblack", metadata=metadata)


ome("ome-zct", voxels(2, 3, 4), "XYZCT", (0.1, 0.2, 0.5), ("µm", "µm", "µm"), "micrometer")
ome("ome-czt", voxels(2, 3, 4), "XYCZT", (0.1, 0.2, 0.5), ("", "", ""), "micrometer")
ome("ome-tcz", voxels(2, 3, 4), "XYTCZ", (10, 20, 30), ("nm", "nm", "nm"), "nanometer")
ome("ome-units", voxels(1, 6, 1), "XYZCT", (1, 1, 2000), ("µm", "µm", "mm"), "micrometer")

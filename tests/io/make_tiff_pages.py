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


# Sets of several OME files: each has a part of the planes, and all of them the same XML, or a companion that has it.
def ome_set(name, v, parts, has_companion=False):
    path = case(name, v, (0.5, 0.5, 2), "micrometer")
    t, z, c, y, x = v.shape
    planes = v.reshape(t * z, c, y, x).transpose(1, 0, 2, 3).reshape(-1, y, x)  # z and t fastest first: XYZTC
    files = [os.path.basename(path)] + [f"{name}-{i}.tif" for i in range(1, parts)]
    share = -(-len(planes) // parts)
    blocks = ""
    for i, plane in enumerate(planes):
        at = f'FirstZ="{i % z}" FirstT="{i // z % t}" FirstC="{i // z // t}"'
        blocks += (f'<TiffData IFD="{i % share}" {at} PlaneCount="1"><UUID FileName="{files[i // share]}">'
                   f'urn:uuid:00000000-0000-0000-0000-{i // share:012}</UUID></TiffData>')
    channels = "".join(f'<Channel ID="Channel:0:{i}" Name="DNA &amp; {i}" SamplesPerPixel="1"/>' for i in range(c))
    spaces = 'xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"'
    uuid = 'UUID="urn:uuid:00000000-0000-0000-0000-{:012}"'
    xml = (f'<?xml version="1.0" encoding="UTF-8"?><OME {spaces} {uuid}><Image ID="Image:0"><Pixels ID="Pixels:0" '
           f'DimensionOrder="XYZTC" Type="uint16" SizeX="{x}" SizeY="{y}" SizeZ="{z}" SizeC="{c}" SizeT="{t}" '
           f'PhysicalSizeX="0.5" PhysicalSizeY="0.5" PhysicalSizeZ="2">{channels}{blocks}</Pixels></Image></OME>')
    if has_companion:
        with open(os.path.join(root, name + ".companion.ome"), "w") as companion:
            companion.write(xml.format(99))
        xml = (f'<OME {spaces} {uuid}><BinaryOnly MetadataFile="{name}.companion.ome" '
               'UUID="urn:uuid:00000000-0000-0000-0000-000000000099"/></OME>')
    for i, file in enumerate(files):
        tifffile.imwrite(os.path.join(root, file), planes[i * share:(i + 1) * share], metadata=None,
                         photometric="minisblack", description=xml.format(i))
    if not has_companion:  # as another reader understands the set
        read = tifffile.imread(path, squeeze=False).reshape(c, t, z, y, x)
        assert (read.transpose(1, 2, 0, 3, 4) == v).all()


ome_set("ome-set", voxels(2, 3, 2), 3)
ome_set("ome-companion", voxels(1, 4, 3), 4, has_companion=True)


# Arrays with their shape alone, or with axes.
def shaped(name, v, axes, **options):
    path = case(name, v, (1, 1, 1), "-")
    order = {"T": 0, "Z": 1, "C": 2}
    stored = np.transpose(v, [order[a] for a in axes] + [order[a] for a in "TZC" if a not in axes] + [3, 4])
    stored = stored.reshape([v.shape[order[a]] for a in axes] + [*v.shape[3:]])
    tifffile.imwrite(path, stored, photometric="minisblack", metadata={"axes": axes + "YX"}, **options)


shaped("shaped-tz", voxels(2, 3, 1), "TZ")
shaped("shaped-czt", voxels(2, 3, 4), "CZT")
shaped("shaped-z-truncated", voxels(1, 5, 1), "Z", truncate=True)
tifffile.imwrite(os.path.join(root, "shaped-unnamed.tif"), voxels(2, 3, 1)[:, :, 0], photometric="minisblack")
one = voxels(1, 5, 1)
tifffile.imwrite(case("shaped-one-axis", one, (1, 1, 1), "-"), one[0, :, 0], photometric="minisblack")


# GDAL's scale and offset.
def scaled(name, scale, pages=5, **options):
    items = [("MEAN", "", "3"), ("OFFSET", ' role="offset"', "-10"), ("SCALE", ' role="scale"', scale), ("UNITS", ' role="unittype"', "K")]
    text = "".join(f'<Item name="{name}" sample="0"{role}>{value}</Item>' for name, role, value in items)
    text += '<Item name="SCALE" sample="1" role="scale">9</Item>'
    tifffile.imwrite(os.path.join(root, name + ".tif"), voxels(1, pages, 1)[0, :, 0], metadata=None,
                     extratags=[(42112, "s", 0, f"<GDALMetadata>{text}</GDALMetadata>", False)], **options)


scaled("scaled", "0.5", photometric="minisblack")
scaled("scaled-by-0", "0", photometric="minisblack")
scaled("one-a", "0.5", 1, photometric="minisblack")
scaled("one-b", "0.25", 1, photometric="minisblack")
scaled("scaled-white", "0.5", photometric="miniswhite")


# GDAL's sparse files: strips and tiles of 0 bytes at 0 are not stored.
def sparse(name, kind, no_data=None, **options):
    v = rng.integers(1, 100, (3, 40, 50)).astype(kind)
    if no_data is not None:
        v[2, 39, 49] = no_data
    fill = 0 if no_data is None else no_data
    path = os.path.join(root, name + ".tif")
    tags = [] if no_data is None else [(42113, "s", 0, str(no_data), False)]
    tifffile.imwrite(path, v, photometric="minisblack", metadata=None, extratags=tags, **options)
    with tifffile.TiffFile(path, mode="r+b") as tif:
        for z, page in enumerate(tif.pages):
            gone = list(range(0, len(page.dataoffsets), 3))  # on all pages: tifffile keeps one list of sizes for them
            for what in ("Offsets", "ByteCounts"):
                tag = page.tags[("Tile" if page.is_tiled else "Strip") + what]
                tag.overwrite([0 if i in gone else n for i, n in enumerate(tag.value)])
            for i in gone:
                if page.is_tiled:
                    y, x = i // -(-50 // 16) * 16, i % -(-50 // 16) * 16
                    v[z, y:y + 16, x:x + 16] = fill
                else:
                    v[z, i * page.rowsperstrip:(i + 1) * page.rowsperstrip] = fill
    if v.dtype.kind == "f" and no_data is not None:
        v[v == no_data] = np.nan
    v.tofile(os.path.join(root, name + ".bin"))
    if v.dtype.kind != "i":  # others have a warning
        cases.write(f"{name} 50 40 3 1 1 1 1 1 -\n")


for stored in ("none", "zlib", "lzma"):
    sparse(f"sparse-strips-{stored}", "u2", compression=None if stored == "none" else stored, rowsperstrip=7)
    sparse(f"sparse-tiles-{stored}", "u2", compression=None if stored == "none" else stored, tile=(16, 16))
sparse("sparse-whole-page", "u2", rowsperstrip=40)
sparse("no-data-integers", "i2", no_data=7, rowsperstrip=7)
sparse("no-data-floats", "f4", no_data=-9999, rowsperstrip=7)


# Reduced images of each page (SubIFDs), level by level in NAME-<level>.bin.
def pyramid(name, pages):
    """`pages`: the levels, each (z, y, x)."""
    with tifffile.TiffWriter(os.path.join(root, name + ".tif"), ome=True) as tif:
        tif.write(pages[0], subifds=len(pages) - 1, photometric="minisblack", tile=(16, 16), compression="zlib",
                  metadata={"axes": "ZYX", "PhysicalSizeX": 0.5, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 2})
        for level in pages[1:]:
            tif.write(level, subfiletype=1, photometric="minisblack", tile=(16, 16))
    for i, level in enumerate(pages):
        np.ascontiguousarray(level).tofile(os.path.join(root, f"{name}-{i}.bin"))


def means(v):
    z, y, x = v.shape
    return v.astype("f8").reshape(z, y // 2, 2, x // 2, 2).mean((2, 4)).round().astype("u2")


fine = voxels(1, 9, 1, 48, 64)[0, :, 0]
pyramid("levels-means", [fine, means(fine), means(means(fine))])
odd = voxels(1, 9, 1, 47, 61)[0, :, 0]
pyramid("levels-strided", [odd, odd[:, ::2, ::2], odd[:, ::4, ::4]])

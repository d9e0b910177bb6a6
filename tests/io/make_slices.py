"""Writes stacks of slices with other programs' writers, each beside the voxels it must be read as.

make_slices.py FOLDER: for each case a folder FOLDER/<case> of slices, the voxels in
FOLDER/<case>.bin (x fastest, this machine's byte order), and in FOLDER/cases.txt a line
"<case> <type> <width> <height> <slices>". TIFF by tifffile, PNG by VTK and by the few lines below.
"""

import os
import struct
import sys
import zlib

import numpy as np
import tifffile
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOImage import vtkPNGWriter, vtkTIFFWriter

NAMES = {"u1": "u8", "i1": "i8", "u2": "u16", "i2": "i16", "u4": "u32", "i4": "i32", "f4": "f32", "f8": "f64"}
rng = np.random.default_rng(7)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")


def volume(kind, shape=(3, 70, 53)):
    """Smooth in part, so that compression compresses, and noisy in part."""
    z, y, x = np.indices(shape)
    values = (z * 31 + y * 3 + x) % 251 + (rng.random(shape) < 0.2) * 3
    if kind.startswith("f"):
        return (values / 7 - 10).astype(kind)
    top = {"u1": 1, "i1": 1, "u2": 200, "i2": 100, "u4": 10_000_000, "i4": 5_000_000}[kind]
    return (values * top - (100 * top if kind[0] == "i" else 0)).astype(kind)


def case(name, voxels):
    os.makedirs(os.path.join(root, name))
    voxels.astype(voxels.dtype.newbyteorder("=")).tofile(os.path.join(root, name + ".bin"))
    depth, height, width = voxels.shape
    kind = NAMES[voxels.dtype.newbyteorder("=").str[1:]]
    cases.write(f"{name} {kind} {width} {height} {depth}\n")
    return lambda z, extension: os.path.join(root, name, f"slice-{z}.{extension}")


def luminance(rgb):
    r, g, b = (rgb[..., c].astype(np.uint64) for c in range(3))
    return ((2126 * r + 7152 * g + 722 * b + 5000) // 10000).astype(rgb.dtype)


def tiffs(name, voxels, pictures=None, **options):
    file = case(name, voxels)
    for z in range(voxels.shape[0]):
        tifffile.imwrite(file(z, "tif"), (voxels if pictures is None else pictures)[z], **options)


def float_tiff(path, values, order, rows_per_strip):
    """With the floating-point predictor, which tifffile does not write: bytes of the same weight together, from the
    most significant on, and of these the differences."""
    height, width = values.shape
    size = values.dtype.itemsize
    strips = []
    for y in range(0, height, rows_per_strip):
        rows = values[y:y + rows_per_strip].astype(">f%d" % size)
        weights = rows.view("u1").reshape(len(rows), width, size).transpose(0, 2, 1).reshape(len(rows), -1)
        differences = weights.copy()
        differences[:, 1:] -= weights[:, :-1]
        strips.append(zlib.compress(differences.tobytes()))
    at = 8
    offsets = []
    for strip in strips:
        offsets.append(at)
        at += len(strip)
    tables = struct.pack(f"{order}{len(strips)}I", *offsets) + struct.pack(f"{order}{len(strips)}I", *map(len, strips))
    tags = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, size * 8), (259, 3, 1, 8), (262, 3, 1, 1),
            (273, 4, len(strips), offsets[0] if len(strips) == 1 else at), (277, 3, 1, 1), (278, 4, 1, rows_per_strip),
            (279, 4, len(strips), len(strips[0]) if len(strips) == 1 else at + 4 * len(strips)), (317, 3, 1, 3), (339, 3, 1, 3)]
    with open(path, "wb") as out:
        out.write((b"II" if order == "<" else b"MM") + struct.pack(order + "HI", 42, at + len(tables)) + b"".join(strips) + tables)
        out.write(struct.pack(order + "H", len(tags)))
        for tag, kind, count, value in tags:
            out.write(struct.pack(order + "HHI", tag, kind, count))
            out.write(struct.pack(order + ("HH" if kind == 3 else "I"), *([value, 0] if kind == 3 else [value])))
        out.write(struct.pack(order + "I", 0))


def zlib_streams(name):
    """NAME.streams: first and last byte of each stream of the first slice, of which every bit is checked."""
    folder = os.path.join(root, name)
    path = os.path.join(folder, sorted(os.listdir(folder))[0])
    data = open(path, "rb").read()
    found = []
    if path.endswith("png"):
        at = 8
        while at < len(data):
            length = struct.unpack_from(">I", data, at)[0]
            if data[at + 4:at + 8] == b"IDAT":
                found.append((at + 8, at + 8 + length))
            at += 12 + length
    else:
        page = tifffile.TiffFile(path).pages[0]
        found = [(o, o + n) for o, n in zip(page.dataoffsets, page.databytecounts)]
    with open(os.path.join(root, name + ".streams"), "w") as out:
        out.writelines(f"{a} {b}\n" for a, b in found)


for kind in NAMES:
    tiffs("tiff-" + NAMES[kind], volume(kind), photometric="minisblack")
tiffs("tiff-strips", volume("u2"), photometric="minisblack", rowsperstrip=7)
tiffs("tiff-one-strip-zlib", volume("u2"), photometric="minisblack", rowsperstrip=70, compression="zlib")
tiffs("tiff-zlib-predictor", volume("u2"), photometric="minisblack", rowsperstrip=16, compression="zlib")
for kind in ("u1", "u2", "i4"):
    tiffs(f"tiff-zlib-differences-{kind}", volume(kind), photometric="minisblack", rowsperstrip=16, compression="zlib", predictor=2)
tiffs("tiff-zlib-differences-swapped", volume("u2"), photometric="minisblack", byteorder=">", compression="zlib", predictor=2)
tiffs("tiff-tiles-zlib-differences", volume("u2"), photometric="minisblack", tile=(16, 32), compression="zlib", predictor=2)
for kind, order, strip in (("f4", "<", 70), ("f4", ">", 16), ("f8", "<", 9)):
    floats = volume(kind)
    file = case(f"tiff-zlib-float-predictor-{kind}-{'II' if order == '<' else 'MM'}", floats)
    for z in range(floats.shape[0]):
        float_tiff(file(z, "tif"), floats[z], order, strip)
tiffs("tiff-big-endian", volume("i2"), photometric="minisblack", byteorder=">", rowsperstrip=9)
tiffs("tiff-big-endian-zlib", volume("f4"), photometric="minisblack", byteorder=">", compression="zlib")
tiffs("tiff-tiles", volume("u1"), photometric="minisblack", tile=(32, 16))
tiffs("tiff-tiles-zlib", volume("f4"), photometric="minisblack", tile=(16, 32), compression="zlib")
tiffs("tiff-bigtiff", volume("u2"), photometric="minisblack", bigtiff=True)
white = volume("u1")
tiffs("tiff-white-is-zero", 255 - white, pictures=white, photometric="miniswhite")
rgb = rng.integers(0, 256, (3, 20, 31, 3)).astype("u1")
tiffs("tiff-rgb-zlib-differences", luminance(rgb), pictures=rgb, photometric="rgb", compression="zlib", predictor=2)
tiffs("tiff-rgb", luminance(rgb), pictures=rgb, photometric="rgb")
rgb16 = rng.integers(0, 65536, (2, 20, 31, 3)).astype("u2")
tiffs("tiff-rgb16-tiles", luminance(rgb16), pictures=rgb16, photometric="rgb", tile=(16, 16))
index = volume("u1")
colors = rng.integers(0, 256, (3, 256)).astype("u2") * 257
tiffs("tiff-palette", (luminance(colors.T[index]) >> 8).astype("u1"), pictures=index, photometric="palette", colormap=colors)

pages = volume("u2", (11, 40, 30))
file = case("tiff-pages", pages)
tifffile.imwrite(file(0, "tif"), pages, photometric="minisblack", compression="zlib", rowsperstrip=10)


def vtk_image(values):
    image = vtkImageData()
    rows = values[::-1]  # VTK's row 0 is the bottom one
    image.SetDimensions(values.shape[1], values.shape[0], 1)
    flat = np.ascontiguousarray(rows).reshape(values.shape[0] * values.shape[1], -1)
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(flat, deep=True))
    return image


def write_with(writer, path, values, compression=None):
    writer.SetFileName(path)
    writer.SetInputData(vtk_image(values))
    if compression is not None:
        getattr(writer, "SetCompressionTo" + compression)()
    writer.Write()


for method in ("PackBits", "Deflate"):
    voxels = volume("u2")
    file = case("tiff-vtk-" + method.lower(), voxels)
    for z in range(voxels.shape[0]):
        write_with(vtkTIFFWriter(), file(z, "tiff"), voxels[z], method)
for kind in ("u1", "u2"):
    voxels = volume(kind)
    file = case("png-vtk-" + NAMES[kind], voxels)
    for z in range(voxels.shape[0]):
        write_with(vtkPNGWriter(), file(z, "png"), voxels[z])
file = case("png-vtk-rgb", luminance(rgb))
for z in range(rgb.shape[0]):
    write_with(vtkPNGWriter(), file(z, "png"), rgb[z])


def pack(rows, bits):
    """Rows of small numbers as bits, most significant first, each with filter type 0 before it."""
    out = b""
    for row in rows:
        if bits >= 8:
            line = row.astype(">u2" if bits == 16 else "u1").tobytes()
        else:
            line = np.packbits(np.unpackbits(row.astype("u1")[:, None], axis=1)[:, 8 - bits:].ravel()).tobytes()
        out += b"\0" + line
    return out


def png(path, values, bits, color_type, palette=None, interlaced=False):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width = values.shape[:2]
    data = b""
    if interlaced:  # Adam7: start and step of x and y of each pass
        for x0, y0, dx, dy in ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)):
            part = values[y0::dy, x0::dx]
            if part.size:
                data += pack([row.ravel() for row in part], bits)
    else:
        data = pack([row.ravel() for row in values], bits)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n")
        out.write(chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, color_type, 0, 0, int(interlaced))))
        out.write(chunk(b"tEXt", b"Comment\0of no interest"))
        if palette is not None:
            out.write(chunk(b"PLTE", palette.astype("u1").tobytes()))
        packed = zlib.compress(data)
        for at in range(0, len(packed), 500):
            out.write(chunk(b"IDAT", packed[at:at + 500]))
        out.write(chunk(b"IEND", b""))


def pngs(name, voxels, pictures, *options, **named):
    file = case(name, voxels)
    for z in range(voxels.shape[0]):
        png(file(z, "png"), pictures[z], *options, **named)


voxels = volume("u2", (2, 37, 29))
pngs("png-interlaced-16", voxels, voxels, 16, 0, interlaced=True)
for bits in (1, 2, 4):
    small = rng.integers(0, 2**bits, (2, 21, 19))
    pngs(f"png-{bits}-bit", (small * (255 // (2**bits - 1))).astype("u1"), small, bits, 0)
gray_alpha = rng.integers(0, 256, (2, 21, 19, 2)).astype("u1")
pngs("png-gray-alpha", gray_alpha[..., 0].copy(), gray_alpha, 8, 4)
rgba16 = rng.integers(0, 65536, (2, 21, 19, 4)).astype("u2")
pngs("png-rgba16", luminance(rgba16), rgba16, 16, 6)
palette = rng.integers(0, 256, (16, 3)).astype("u1")
index = rng.integers(0, 16, (2, 21, 19))
pngs("png-palette-4-bit", luminance(palette[index]), index, 4, 3, palette=palette)
gray = volume("u1", (2, 21, 19))
pngs("png-gray-stored-as-rgb", gray, np.repeat(gray[..., None], 3, axis=3), 8, 2)

for name in ("tiff-zlib-predictor", "tiff-one-strip-zlib", "tiff-tiles-zlib", "tiff-zlib-differences-u2", "tiff-vtk-deflate",
             "tiff-zlib-float-predictor-f4-MM", "png-vtk-u16", "png-4-bit", "png-interlaced-16"):
    zlib_streams(name)

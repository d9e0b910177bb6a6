"""Writes .vti and legacy .vtk files with VTK, each beside the voxels it must be read as.

make_vtk.py FOLDER: as make_zarr.py; the last word of a line is the name of the array, or "-" for the first.
"""

import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkStructuredPoints
from vtkmodules.vtkIOLegacy import vtkStructuredPointsReader, vtkStructuredPointsWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

sys.dont_write_bytecode = True
from voxel_pattern import voxels_of

NAMES = {"uint8": "u8", "int8": "i8", "uint16": "u16", "int16": "i16", "uint32": "u32", "int32": "i32", "float32": "f32", "float64": "f64"}
rng = np.random.default_rng(3)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")
SHAPE = (9, 11, 13)


def image_of(values, of_cells=False, start=(0, 0, 0), direction=None, kind=vtkImageData):
    """`values`: arrays of one shape by their names."""
    shape = next(iter(values.values())).shape
    image = kind()
    more = 0 if of_cells else -1
    image.SetExtent(*(n for a in range(3) for n in (start[a], start[a] + shape[2 - a] + more)))
    image.SetSpacing(0.5, 0.25, 2)
    image.SetOrigin(1, 2, 3)
    if direction:
        image.SetDirectionMatrix(direction)
    data = image.GetCellData() if of_cells else image.GetPointData()
    for name, array in values.items():
        numbers = numpy_to_vtk(np.ascontiguousarray(array).reshape(-1), deep=True)
        numbers.SetName(name)
        data.AddArray(numbers)
    data.SetActiveScalars(next(iter(values)))
    return image


def says(file, values, name="-"):
    values.tofile(os.path.join(root, file) + ".bin")
    cases.write(f"{file} {NAMES[values.dtype.name]} {values.shape[2]} {values.shape[1]} {values.shape[0]} {name}\n")


def vti(file, image, mode="appended", encode=False, compressor=None, big=False, wide=False, block=1 << 15):
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(os.path.join(root, file))
    writer.SetInputData(image)
    getattr(writer, {"appended": "SetDataModeToAppended", "binary": "SetDataModeToBinary", "ascii": "SetDataModeToAscii"}[mode])()
    writer.SetEncodeAppendedData(encode)
    getattr(writer, f"SetCompressorTypeTo{compressor or 'None'}")()
    getattr(writer, "SetByteOrderToBigEndian" if big else "SetByteOrderToLittleEndian")()
    getattr(writer, "SetHeaderTypeToUInt64" if wide else "SetHeaderTypeToUInt32")()
    writer.SetBlockSize(block)
    assert writer.Write() == 1


for kind in NAMES:
    values = voxels_of(rng, kind, SHAPE)
    image = image_of({"a": values})
    for name, more in (("raw", {}), ("ascii", {"mode": "ascii"}), ("base64", {"mode": "binary", "wide": True}),
                       ("zlib", {"compressor": "ZLib", "block": 1024})):
        vti(f"{name}_{kind}.vti", image, **more)
        says(f"{name}_{kind}.vti", values)
    for text in (False,) if kind == "uint8" else (False, True):  # as text VTK writes bytes as colours
        writer = vtkStructuredPointsWriter()
        writer.SetFileName(os.path.join(root, f"legacy_{kind}_{text}.vtk"))
        writer.SetInputData(image_of({"a": values}, kind=vtkStructuredPoints))
        if not text:
            writer.SetFileTypeToBinary()
        writer.Write()
        reader = vtkStructuredPointsReader()  # as text VTK writes few digits of a float
        reader.SetFileName(writer.GetFileName())
        reader.Update()
        seen = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(SHAPE).astype(kind)
        assert text or np.array_equal(seen, values)
        says(f"legacy_{kind}_{text}.vtk", seen)
values = voxels_of(rng, "uint16", SHAPE)
image = image_of({"a": values})
for mode, encode in (("appended", False), ("appended", True), ("binary", False)):
    for compressor in (None, "ZLib", "LZ4", "LZMA"):
        for big, wide in ((False, False), (True, False), (False, True)):
            for block in ((512, 1 << 20) if compressor else (1 << 20,)):
                file = f"{mode}{encode}{compressor}{big}{wide}{block}.vti"
                vti(file, image, mode, encode, compressor, big, wide, block)
                says(file, values)
several = {"first": voxels_of(rng, "uint8", SHAPE), "second one": voxels_of(rng, "float32", SHAPE), "third": voxels_of(rng, "int16", SHAPE)}
for mode in ("appended", "ascii", "binary"):
    vti(f"several_{mode}.vti", image_of(several), mode)
    for name in ("first", "third"):
        os.link(os.path.join(root, f"several_{mode}.vti"), os.path.join(root, f"several_{mode}_{name}.vti"))
        says(f"several_{mode}_{name}.vti", several[name], name)
for text in (False, True):
    image = image_of(several, kind=vtkStructuredPoints)
    writer = vtkStructuredPointsWriter()
    writer.SetFileName(os.path.join(root, f"several_{text}.vtk"))
    writer.SetInputData(image)
    if not text:
        writer.SetFileTypeToBinary()
    writer.Write()
    for name in ("third",) if text else ("first", "third"):
        os.link(os.path.join(root, f"several_{text}.vtk"), os.path.join(root, f"several_{text}_{name}.vtk"))
        says(f"several_{text}_{name}.vtk", several[name], name)
values = voxels_of(rng, "uint8", SHAPE)
vti("start.vti", image_of({"a": values}, start=(-3, 4, 10)))
says("start.vti", values)
vti("cells.vti", image_of({"a": values}, of_cells=True, start=(2, 0, 0)))
says("cells.vti", values)
vti("turned.vti", image_of({"a": values}, direction=(0, -1, 0, 1, 0, 0, 0, 0, 1)))
says("turned.vti", values)

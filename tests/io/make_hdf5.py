"""Writes data sets into HDF5 files with h5py, each beside the voxels it must be read as.

make_hdf5.py FOLDER: as make_zarr.py; a case is "FILE:/SET", its voxels lie in FILE.SET.bin.
"""

import json
import os
import sys

import h5py
import numpy as np

sys.dont_write_bytecode = True
from voxel_pattern import voxels_of

NAMES = {"bool": "i8", "uint8": "u8", "int8": "i8", "uint16": "u16", "int16": "i16", "uint32": "u32", "int32": "i32", "float32": "f32",
         "float64": "f64"}
rng = np.random.default_rng(9)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")
SHAPE = (11, 13, 17)


def says(file, name, values, seen=None, steps=1, channel=-1):
    seen = values if seen is None else seen
    seen = np.ascontiguousarray(seen).astype(seen.dtype.newbyteorder("="))
    seen.tofile(os.path.join(root, f"{file}.{name}.bin"))
    dims = (1, 1, *seen.shape)[-3:]
    cases.write(f"{file}:/{name} {NAMES[seen.dtype.name]} {dims[2]} {dims[1]} {dims[0]} {steps} {channel} 0\n")


file = h5py.File(os.path.join(root, "sets.h5"), "w")
for kind in NAMES:
    for order in "<>":
        if kind == "bool" and order == ">":
            continue
        values = voxels_of(rng, kind, SHAPE)
        stored = values if kind == "bool" else values.astype(values.dtype.newbyteorder(order))
        end = "big" if order == ">" else "little"
        file.create_dataset(f"flat_{kind}_{end}", data=stored)
        says("sets.h5", f"flat_{kind}_{end}", values)
        file.create_dataset(f"chunked_{kind}_{end}", data=stored, chunks=(4, 5, 6), compression="gzip", shuffle=True)
        says("sets.h5", f"chunked_{kind}_{end}", values)
values = voxels_of(rng, "uint16", SHAPE)
for name, more in (("plain", {}), ("gzip", {"compression": "gzip"}), ("lzf", {"compression": "lzf"}), ("szip", {"compression": "szip"}),
                   ("shuffle", {"shuffle": True}), ("sum", {"fletcher32": True}), ("scaled", {"scaleoffset": 0}),
                   ("all", {"compression": "gzip", "shuffle": True, "fletcher32": True}), ("lzf_all", {"compression": "lzf", "shuffle": True, "fletcher32": True})):
    if name == "szip" and not h5py.h5z.filter_avail(h5py.h5z.FILTER_SZIP):
        continue
    for chunks in ((4, 5, 6), (11, 13, 17), (1, 13, 17)):
        at = f"packed_{name}_{chunks[0]}"
        file.create_dataset(at, data=values, chunks=chunks, **more)
        says("sets.h5", at, values)
odd = voxels_of(rng, "uint8", (7, 9, 11))
file.create_dataset("odd_sum", data=odd, chunks=(7, 3, 11), fletcher32=True)
says("sets.h5", "odd_sum", odd)
noise = rng.integers(0, 256, SHAPE).astype("uint8")  # which LZF leaves as it is
file.create_dataset("noise", data=noise, chunks=(4, 5, 6), compression="lzf")
says("sets.h5", "noise", noise)
for kind in ("uint8", "float32"):
    holes = file.create_dataset(f"holes_{kind}", shape=SHAPE, dtype=kind, chunks=(4, 5, 6), fillvalue=7)
    holes[0:4, 5:13, :] = 3
    says("sets.h5", f"holes_{kind}", holes[...])
file.create_dataset("empty", shape=SHAPE, dtype="uint8")
says("sets.h5", "empty", np.zeros(SHAPE, "uint8"))
small = file.create_dataset("compact_parent", data=values[0])
says("sets.h5", "compact_parent", values[0])
compact = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
compact.set_layout(h5py.h5d.COMPACT)
set_id = h5py.h5d.create(file.id, b"compact", h5py.h5t.NATIVE_UINT8, h5py.h5s.create_simple((3, 4, 5)), compact)
h5py.Dataset(set_id)[...] = odd[:3, :4, :5]
says("sets.h5", "compact", odd[:3, :4, :5])
for name, chunks in (("steps", None), ("steps_chunked", (2, 4, 4, 4))):
    steps = voxels_of(rng, "uint8", (3, 9, 10, 11))
    file.create_dataset(name, data=steps, chunks=chunks)
    says("sets.h5", name, steps, steps=3)
five = voxels_of(rng, "uint16", (2, 3, 7, 8, 9))
for name, chunks in (("five", None), ("five_chunked", (1, 1, 4, 4, 4))):
    file.create_dataset(name, data=five, chunks=chunks)
    for channel in (0, 2):
        with_channel = f"{name}_{channel}"
        file[with_channel] = file[name]
        says("sets.h5", with_channel, five, five[:, channel], 2, channel)
tagged = voxels_of(rng, "float32", (2, 7, 8, 9, 3))  # t z y x c
for name, chunks in (("tagged", None), ("tagged_chunked", (1, 4, 4, 4, 3))):
    data = file.create_dataset(name, data=tagged, chunks=chunks)
    data.attrs["axistags"] = json.dumps({"axes": [{"key": key, "typeFlags": 2, "resolution": 0, "description": ""} for key in "tzyxc"]})
    data.attrs["element_size_um"] = [2.0, 0.5, 0.25]
    says("sets.h5", name, tagged, tagged[..., 1], 2, 1)
sized = file.create_dataset("sized", data=values)
sized.attrs["element_size_um"] = np.array([2, 0.5, 0.25], "float32")
says("sets.h5", "sized", values)
group = file.create_group("a/b")
group.create_dataset("deep", data=values)
file["soft"] = h5py.SoftLink("/a/b/deep")
says("sets.h5", "soft", values)
file["elsewhere"] = h5py.ExternalLink("one.h5", "/only")
file.create_dataset("long", data=np.zeros((2, 2, 2), "int64"))
virtual = h5py.VirtualLayout((11, 13, 17), "uint16")
virtual[...] = h5py.VirtualSource("one.h5", "only", SHAPE)
file.create_virtual_dataset("virtual", virtual)
file.close()

with h5py.File(os.path.join(root, "one.h5"), "w", libver="latest", userblock_size=1024) as one:
    one.create_dataset("only", data=values, chunks=(4, 5, 6), compression="gzip")
    one.create_dataset("x", data=np.arange(17, dtype="uint8"))
says("one.h5", "only", values)
with h5py.File(os.path.join(root, "block.h5"), "w", userblock_size=512) as one:
    one.create_dataset("flat", data=values)
says("block.h5", "flat", values)
with h5py.File(os.path.join(root, "packed.nc"), "w") as netcdf:
    data = netcdf.create_dataset("t", data=values.astype("int16"))
    data.attrs["scale_factor"], data.attrs["add_offset"] = 0.5, 10.0
says("packed.nc", "t", values.astype("int16"))
with h5py.File(os.path.join(root, "none.h5"), "w") as none:
    none.create_dataset("curve", data=np.arange(5))
with h5py.File(os.path.join(root, "flat.h5"), "w") as flat:
    flat.create_dataset("first", data=values[0])
    flat.create_dataset("second", data=values[1])
with h5py.File(os.path.join(root, "types.h5"), "w") as types:
    types["long"], types["half"], types["text"] = np.zeros((2, 2, 2), "int64"), np.zeros((2, 2, 2), "float16"), np.full((2, 2, 2), b"a")
    types["record"] = np.zeros((2, 2, 2), [("a", "i4"), ("b", "f4")])


def grid(file, axes, voxels, **attributes):
    """A variable as NetCDF-4 has it. `axes`: name, positions (an extent if it has none), units and other attributes."""
    with h5py.File(os.path.join(root, file), "w") as netcdf:
        data = netcdf.create_dataset("v", data=voxels, fillvalue=attributes.get("_FillValue"))
        for i, (axis, positions, more) in enumerate(axes):
            has_none = isinstance(positions, int)
            scale = netcdf.create_dataset(axis, data=np.zeros(positions, "f4") if has_none else np.asarray(positions))
            scale.make_scale(f"This is a netCDF dimension but not a netCDF variable. {positions:9}" if has_none else axis)
            for key, value in more.items():
                scale.attrs[key] = value
            data.dims[i].attach_scale(scale)
        for key, value in attributes.items():
            data.attrs[key] = value


MM, NORTH, EAST = {"units": "mm"}, {"units": "degrees_north"}, {"units": "degrees_east"}
floats = voxels_of(rng, "float32", (3, 4, 5))
X, Y, Z = ("x", 0.25 * np.arange(5) - 1, MM), ("y", 0.5 * np.arange(4, dtype="f4"), MM), ("z", 10 - 2.0 * np.arange(3), MM)
grid("grid.nc", [Z, Y, X], floats)
grid("units.nc", [Z, Y, ("x", *X[1:2], {"units": "um"})], floats)
grid("turned.nc", [("x", 0.25 * np.arange(3), MM), ("y", *Y[1:]), ("z", 2.0 * np.arange(5), MM)], floats)
grid("uneven.nc", [("z", [1.0, 2, 5], {}), ("y", Y[1], {}), ("x", X[1], {})], floats)
grid("pressure.nc", [("lev", [1000.0, 500, 1], {"units": "hPa"}), ("lat", Y[1], NORTH), ("lon", X[1], EAST)], floats)
grid("degrees.nc", [("lev", 3, {}), ("lat", Y[1], NORTH), ("lon", X[1], EAST)], floats)
grid("hours.nc", [("t0", [6.0], {"units": "hours since 1900-01-01"}), Z, Y, X], floats[None])
grid("layer.nc", [("height", [2.0], {"units": "m"}), ("lat", Y[1], NORTH), ("lon", X[1], EAST)], floats[:1])
masked = floats.copy()
masked[1] = -999
grid("masked.nc", [Z, Y, X], masked, _FillValue=np.float32(-999), missing_value=np.float32(-999))
seen = masked.copy()
seen[1] = np.nan
says("masked.nc", "v", seen)
grid("gaps.nc", [Z, Y, X], voxels_of(rng, "int16", (3, 4, 5)), _FillValue=np.int16(-32768), scale_factor=0.5, add_offset=1.0)
signed = voxels_of(rng, "int8", (3, 4, 5))
grid("valid.nc", [Z, Y, X], voxels_of(rng, "int16", (3, 4, 5)), valid_range=np.array([-10, 300], "i2"), scale_factor=0.5)
grid("all-valid.nc", [Z, Y, X], voxels_of(rng, "uint8", (3, 4, 5)), valid_min=np.uint8(0), valid_max=np.uint8(255))
grid("positive.nc", [Z, Y, X], voxels_of(rng, "float32", (3, 4, 5)), valid_min=np.float32(0), _FillValue=np.float32(-9))
grid("unsigned.nc", [Z, Y, X], signed, _Unsigned="true", _FillValue=np.int8(-1))
says("unsigned.nc", "v", signed.view("uint8"))

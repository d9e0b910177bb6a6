"""Writes images of microscopes with h5py and zarr-python, laid out as Imaris and BigDataViewer do, each beside its voxels.

make_microscopes.py FOLDER: as make_zarr.py. Voxels of level 0 lie in NAME.bin, those of level 1, time step 1 and channel 1 in
NAME.level.bin.
"""

import os
import sys
import warnings

import h5py
import numcodecs
import numpy as np
import zarr

sys.dont_write_bytecode = True
warnings.filterwarnings("ignore")
from voxel_pattern import voxels_of

rng = np.random.default_rng(13)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")
TIMES, CHANNELS, SHAPE = 3, 2, (10, 12, 14)
fine = voxels_of(rng, "uint16", (TIMES, CHANNELS, *SHAPE)) + np.uint16(40000)  # beyond int16
coarse = fine.reshape(TIMES, CHANNELS, 5, 2, 6, 2, 7, 2).mean(axis=(3, 5, 7)).astype("uint16")


def says(name, channel):
    fine[:, max(channel, 0)].tofile(os.path.join(root, f"{name}.bin"))
    coarse[1, 1].tofile(os.path.join(root, f"{name}.level.bin"))
    cases.write(f"{name} u16 {SHAPE[2]} {SHAPE[1]} {SHAPE[0]} {TIMES} {channel} 0\n")


def letters(group, **texts):
    """Imaris keeps texts as arrays of letters."""
    for name, text in texts.items():
        group.attrs[name] = np.frombuffer(str(text).encode(), "S1")


def imaris(path, cut=0):
    """`cut`: voxels that channel 1 has less along x."""
    with h5py.File(path, "w") as file:
        for level, values in enumerate((fine, coarse)):
            for t in range(TIMES):
                for c in range(CHANNELS):
                    part = values[t, c]
                    padded = np.zeros([-(-n // 8) * 8 for n in part.shape], "uint16")
                    padded[tuple(slice(n) for n in part.shape)] = part
                    group = file.create_group(f"DataSet/ResolutionLevel {level}/TimePoint {t}/Channel {c}")
                    group.create_dataset("Data", data=padded, chunks=(8, 8, 8), compression="gzip")
                    letters(group, ImageSizeX=part.shape[2] - cut * c, ImageSizeY=part.shape[1], ImageSizeZ=part.shape[0])
        letters(file.create_group("DataSetInfo/Image"), X=14, Y=12, Z=10, Unit="um", ExtMin0="1.0", ExtMax0="8.0", ExtMin1="0", ExtMax1="6",
                ExtMin2="-5", ExtMax2="15")
        for c, name in enumerate(("DAPI", "GFP")):
            letters(file.create_group(f"DataSetInfo/Channel {c}"), Name=name)


def bdv_hdf5(path, missing=()):
    with h5py.File(path, "w") as file:
        for c in range(CHANNELS):
            file[f"s{c:02}/resolutions"] = np.array([[1.0, 1, 1], [2, 2, 2]])
            file[f"s{c:02}/subdivisions"] = np.array([[8, 8, 8], [4, 4, 4]], "int32")
            for t in range(TIMES):
                for level, values in enumerate((fine, coarse) if (t, c) not in missing else ()):
                    file.create_dataset(f"t{t:05}/s{c:02}/{level}/cells", data=values[t, c].view("int16"), chunks=(4, 4, 4), compression="gzip")


def bdv_n5(path):
    for c in range(CHANNELS):
        setup = zarr.open_group(zarr.N5Store(os.path.join(path, f"setup{c}")), mode="w")
        setup.attrs["downsamplingFactors"] = [[1, 1, 1], [2, 2, 2]]
        for t in range(TIMES):
            for level, values in enumerate((fine, coarse)):
                setup.array(f"timepoint{t}/s{level}", values[t, c], chunks=(4, 8, 6), compressor=numcodecs.GZip(1))


def xml(path, loader, affines=("0.5 0 0 1 0 0.5 0 2 0 0 2 3",), second=None, missing=()):
    transforms = "".join(f'<ViewTransform type="affine"><affine>{a}</affine></ViewTransform>' for a in affines)
    registrations = "".join(f'<ViewRegistration timepoint="{t}" setup="{s}">{second if second and t == 1 else transforms}</ViewRegistration>'
                            for t in range(TIMES) for s in range(CHANNELS))
    setups = "".join(f"<ViewSetup><id>{s}</id><name>{n}</name><size>14 12 10</size><voxelSize><unit>um</unit><size>1 1 4</size></voxelSize>"
                     "</ViewSetup>" for s, n in enumerate(("DAPI", "GFP")))
    views = "".join(f'<MissingView timepoint="{t}" setup="{s}"/>' for t, s in missing)
    with open(path, "w") as file:
        file.write(f'<?xml version="1.0" encoding="UTF-8"?>\n<SpimData version="0.2"><BasePath type="relative">.</BasePath><SequenceDescription>'
                   f'{loader}<ViewSetups>{setups}</ViewSetups><Timepoints type="range"><first>0</first><last>{TIMES - 1}</last></Timepoints>'
                   f'<MissingViews>{views}</MissingViews>'
                   f"</SequenceDescription><ViewRegistrations>{registrations}</ViewRegistrations></SpimData>\n")


imaris(os.path.join(root, "image.ims"))
imaris(os.path.join(root, "cut.ims"), cut=1)
bdv_hdf5(os.path.join(root, "bdv.h5"))
bdv_n5(os.path.join(root, "bdv.n5"))
MISSING = ((0, 1), (2, 1), (0, 0), (1, 0), (2, 0))
bdv_hdf5(os.path.join(root, "missing.h5"), MISSING)
HDF5 = '<ImageLoader format="bdv.hdf5"><hdf5 type="relative">bdv.h5</hdf5></ImageLoader>'
xml(os.path.join(root, "hdf5.xml"), HDF5, ("1 0 0 1 0 1 0 2 0 0 1 3", "0.5 0 0 0 0 0.5 0 0 0 0 2 0"))
N5 = '<ImageLoader format="bdv.n5" version="1.0"><n5 type="relative">bdv.n5</n5></ImageLoader>'
xml(os.path.join(root, "n5.xml"), N5)
xml(os.path.join(root, "turned.xml"), HDF5, ("0 -0.5 0 0 0.5 0 0 0 0 0 2 0",))
xml(os.path.join(root, "moved.xml"), HDF5, second='<ViewTransform type="affine"><affine>1 0 0 9 0 1 0 0 0 0 1 0</affine></ViewTransform>')
xml(os.path.join(root, "missing.xml"), HDF5.replace("bdv.h5", "missing.h5"), missing=MISSING)
xml(os.path.join(root, "missing_n5.xml"), N5, missing=MISSING)
for name in ("image.ims", "bdv.h5", "hdf5.xml", "n5.xml"):
    says(name, 1)

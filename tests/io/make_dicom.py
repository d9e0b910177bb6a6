"""Writes DICOM series with pydicom, and compresses some of them with GDCM's gdcmconv if it is there.

make_dicom.py FOLDER: for each case a folder FOLDER/<case> of files, the voxels that must be read from it
in FOLDER/<case>.bin (x fastest, time step after time step, this machine's byte order), and in
FOLDER/cases.txt a line "<case> <x> <y> <z> <time steps> <type> <spacing x, y, z> <unit> <scale> <offset>".
The patient is called what no output may contain.
"""

import os
import shutil
import subprocess
import sys

import numpy as np
import pydicom
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.sequence import Sequence
from pydicom.uid import ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian

rng = np.random.default_rng(7)
root = sys.argv[1]
cases = open(os.path.join(root, "cases.txt"), "w")
NX, NY, NZ = 20, 14, 9
TYPES = {"i2": "i16", "u2": "u16", "u1": "u8", "i1": "i8", "u4": "u32", "i4": "i32", "f4": "f32", "f8": "f64"}


def smooth(kind, low, high, shape=(NZ, NY, NX)):
    z, y, x = np.indices(shape)
    values = (x * 7 + y * 11 + z * 5 + (rng.random(shape) < 0.2) * 3) % 61 / 60
    return (low + values * (high - low)).astype(kind)


def listed(name, voxels, spacing=(0.5, 0.75, 2.5), unit="millimeter", scale=1, offset=0):
    """`voxels`: t, z, y, x or z, y, x, as they must be read."""
    if voxels.ndim == 3:
        voxels = voxels[None]
    np.ascontiguousarray(voxels).tofile(os.path.join(root, name + ".bin"))
    t, z, y, x = voxels.shape
    kind = TYPES[voxels.dtype.str[1:]]
    cases.write(f"{name} {x} {y} {z} {t} {kind} {spacing[0]} {spacing[1]} {spacing[2]} {unit or '-'} {scale} {offset}\n")
    folder = os.path.join(root, name)
    os.makedirs(folder, exist_ok=True)
    return folder


def image(uid, stored, bits=None, number=1, series=3, modality="CT"):
    """A data set with the pixels `stored`: y, x, or frames, y, x."""
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
    meta.MediaStorageSOPInstanceUID = uid
    meta.TransferSyntaxUID = ExplicitVRLittleEndian
    d = FileDataset("", {}, file_meta=meta, preamble=b"\0" * 128)
    d.SOPClassUID, d.SOPInstanceUID = meta.MediaStorageSOPClassUID, uid
    d.PatientName, d.PatientID, d.PatientBirthDate = "Xqzpatient^Secret", "XQZPATIENT1", "19010203"
    d.InstitutionName, d.ReferringPhysicianName = "Xqzpatient Hospital", "Xqzpatient^Doctor"
    d.StudyInstanceUID, d.SeriesInstanceUID = "1.2.3", f"1.2.3.{series}"
    d.SeriesDescription = "Xqzpatient's head"
    d.Modality, d.SeriesNumber, d.InstanceNumber = modality, series, number
    d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
    d.Rows, d.Columns = stored.shape[-2:]
    if stored.ndim == 3:
        d.NumberOfFrames = stored.shape[0]
    d.BitsAllocated = stored.itemsize * 8
    d.BitsStored = bits or d.BitsAllocated
    d.HighBit = d.BitsStored - 1
    d.PixelRepresentation = 1 if stored.dtype.kind == "i" else 0
    d.PixelData = stored.tobytes()
    d["PixelData"].VR = "OW" if d.BitsAllocated > 8 else "OB"
    d.is_little_endian, d.is_implicit_VR = True, False
    return d


def place(d, z, spacing=(0.5, 0.75, 2.5), origin=(-10, 20, 30), along=(0, 0, 1)):
    d.PixelSpacing = [spacing[1], spacing[0]]
    d.SliceThickness = spacing[2]
    d.ImagePositionPatient = [float(round(origin[i] + z * spacing[2] * along[i], 6)) for i in range(3)]
    d.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]


def save(d, path, syntax=ExplicitVRLittleEndian):
    d.file_meta.TransferSyntaxUID = syntax
    d.is_little_endian, d.is_implicit_VR = syntax != ExplicitVRBigEndian, syntax == ImplicitVRLittleEndian
    d.save_as(path, write_like_original=False)


def series(folder, stored, change=None, name="I{:03d}", syntax=ExplicitVRLittleEndian, uid="1.2.3", **options):
    """A file a slice. Neither names nor numbers are in the order of the positions."""
    order = rng.permutation(len(stored))
    for i, z in enumerate(order):
        d = image(f"{uid}.9.{z + 1}", stored[z], number=len(stored) - i, **options)
        place(d, z)
        if change:
            change(d, z)
        save(d, os.path.join(folder, name.format(i)), syntax)


# --- Plain pixels

ct = smooth("i2", -200, 3000)


def hounsfield(d, z):
    d.RescaleSlope, d.RescaleIntercept = 1, -1024


series(listed("ct", ct, offset=-1024), ct, hounsfield)
series(listed("implicit", ct, offset=-1024), ct, hounsfield, syntax=ImplicitVRLittleEndian)


def padded(d, z):
    hounsfield(d, z)
    d.add_new("PixelPaddingValue", "SS", -2000)


def padded_range(d, z):
    padded(d, z)
    d.add_new("PixelPaddingRangeLimit", "SS", -2100)


series(listed("padded", ct, offset=-1024), ct, padded)
series(listed("padded-range", ct, offset=-1024), ct, padded_range)


def swapped(d, z):
    hounsfield(d, z)
    d.PixelData = ct[z].byteswap().tobytes()


series(listed("big-endian", ct, offset=-1024), ct, swapped, syntax=ExplicitVRBigEndian)
u8 = smooth("u1", 0, 255)
series(listed("u8", u8), u8)
u32 = smooth("u4", 0, 2**32 - 1)
series(listed("u32", u32), u32)

# 12 bits with an overlay above them, and with a sign.
u12 = smooth("u2", 0, 4095)
series(listed("u12", u12), u12 | 0xA000, bits=12)
i12 = smooth("i2", -2048, 2047)
series(listed("i12", i12), i12 & 0x0FFF, bits=12)


def high_bits(d, z):
    d.HighBit = 15
    d.PixelData = (u12[z] << 4 | 5).astype("u2").tobytes()


series(listed("u12-high", u12), u12, high_bits, bits=12)

# Values by slices: whole numbers that fit, and others.


def by_slice(d, z):
    d.RescaleSlope, d.RescaleIntercept = 1 + z % 2, -1024 - z


scaled = np.stack([u12[z].astype("i2") * (1 + z % 2) - 1024 - z for z in range(NZ)]).astype("i2")
series(listed("by-slice", scaled), u12, by_slice, bits=12)


def by_dose(d, z):
    d.RescaleSlope, d.RescaleIntercept = f"{0.5 + z / 16}", 0


pet = np.stack([(u12[z] * (0.5 + z / 16)).astype("f4") for z in range(NZ)])
series(listed("pet", pet), u12, by_dose, bits=12, modality="PT")

# --- Where slices lie


def tilted(d, z):
    place(d, z, along=(0, 0.2, 1))


series(listed("tilt", ct, (0.5, 0.75, 2.5 * 1.04 ** 0.5)), ct, tilted)


def flipped(d, z):  # from foot to head, seen the other way round
    place(d, NZ - 1 - z)


series(listed("flipped", ct[::-1]), ct, flipped)
folder = listed("missing", np.delete(ct, [4, 5], axis=0))
series(folder, ct, name="P{:03d}")
for name in os.listdir(folder):
    if pydicom.dcmread(os.path.join(folder, name)).ImagePositionPatient[2] in (40.0, 42.5):
        os.remove(os.path.join(folder, name))
folder = os.path.join(root, "far")  # one slice is further away than integers count slices
os.makedirs(folder)
series(folder, ct, name="P{:03d}")
last = sorted(os.listdir(folder), key=lambda name: pydicom.dcmread(os.path.join(folder, name)).ImagePositionPatient[2])[-1]
far = pydicom.dcmread(os.path.join(folder, last))
far.ImagePositionPatient[2] = "1e25"
far.save_as(os.path.join(folder, last))
folder = listed("copies", ct)
series(folder, ct)
shutil.copy(os.path.join(folder, "I003"), os.path.join(folder, "Z003"))
folder = listed("times", np.stack([ct, ct + 5, ct + 9]))
for t, add in enumerate((0, 5, 9)):
    series(folder, ct + add, lambda d, z: setattr(d, "AcquisitionNumber", t + 1), name=f"t{3 - t}-{{}}", uid=f"1.2.4.{t}")
one_row = smooth("i2", 0, 99, (6, NY, NX))
folder = listed("no-positions", one_row, (1, 1, 1), "")
for z in range(6):
    d = image(f"1.2.3.5.{z}", one_row[z], number=z + 1)
    save(d, os.path.join(folder, f"s{5 - z}"))
folder = listed("folders", ct)
for part in range(3):
    os.makedirs(os.path.join(folder, f"disk{part}"))
series(folder, ct)
for i, name in enumerate(sorted(n for n in os.listdir(folder) if n.startswith("I"))):
    os.rename(os.path.join(folder, name), os.path.join(folder, f"disk{i % 3}", name))
open(os.path.join(folder, "README"), "w").write("not an image\n")

# One slice is of larger pixels; no slice tells the size of its pixels.
folder = listed("sizes", ct)
series(folder, ct)
d = image("1.2.3.10.1", ct[0])
place(d, 100, spacing=(0.9, 0.9, 2.5))
save(d, os.path.join(folder, "larger"))
series(listed("unsized", ct, (1, 1, 2.5)), ct, lambda d, z: delattr(d, "PixelSpacing"))

# Two series, and a scout of another size in one of them.
folder = listed("several", ct)
series(folder, ct)
for z in range(2):
    d = image(f"1.2.8.{z}", u8[z], series=4, modality="MR")
    place(d, z)
    save(d, os.path.join(folder, f"other{z}"))
save(image("1.2.9.1", np.zeros((40, 30), "i2")), os.path.join(folder, "scout"))

# --- Colors, floats, a dose


def colored(d, z):
    d.SamplesPerPixel, d.PhotometricInterpretation, d.PlanarConfiguration = 3, "RGB", z % 2
    color = np.stack([u8[z], u8[z] // 2, 255 - u8[z]], axis=0 if z % 2 else -1)
    d.PixelData = np.ascontiguousarray(color).tobytes()


weights = (2126 * u8.astype("u4") + 7152 * (u8.astype("u4") // 2) + 722 * (255 - u8.astype("u4")) + 5000) // 10000
series(listed("colors", weights.astype("u1")), u8, colored)


def floats(d, z):
    del d.PixelData
    d.FloatPixelData = (ct[z] / 7).astype("f4").tobytes()
    d.BitsAllocated = 32


series(listed("floats", (ct / 7).astype("f4")), ct, floats)
dose = smooth("u4", 0, 10**6)
d = image("1.2.3.6", dose, modality="RTDOSE")
place(d, 0)
d.GridFrameOffsetVector = [2.5 * z for z in range(NZ)]
d.DoseGridScaling = "0.0001"
save(d, os.path.join(listed("dose", dose, scale=0.0001), "dose.dcm"))

# --- Frames of one file, with properties of their own


def functions(z, slope):
    f = Dataset()
    f.PlanePositionSequence = Sequence([Dataset()])
    f.PlanePositionSequence[0].ImagePositionPatient = [-10, 20, 30 + 2.5 * int(z)]
    f.PixelValueTransformationSequence = Sequence([Dataset()])
    f.PixelValueTransformationSequence[0].RescaleIntercept = -1024
    f.PixelValueTransformationSequence[0].RescaleSlope = slope
    return f


def enhanced(order):
    d = image("1.2.3.7", np.ascontiguousarray(ct[order]))
    shared = Dataset()
    shared.PlaneOrientationSequence = Sequence([Dataset()])
    shared.PlaneOrientationSequence[0].ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
    shared.PixelMeasuresSequence = Sequence([Dataset()])
    shared.PixelMeasuresSequence[0].PixelSpacing = [0.75, 0.5]
    shared.PixelMeasuresSequence[0].SliceThickness = 2.5
    d.SharedFunctionalGroupsSequence = Sequence([shared])
    d.PerFrameFunctionalGroupsSequence = Sequence([functions(z, 1) for z in order])
    # A sequence with positions that are not the frames'.
    source = Dataset()
    source.ImagePositionPatient = [1, 2, 3]
    d.SourceImageSequence = Sequence([source])
    return d


order = rng.permutation(NZ)
save(enhanced(order), os.path.join(listed("enhanced", ct, offset=-1024), "e.dcm"))
save(enhanced(order), os.path.join(listed("enhanced-implicit", ct, offset=-1024), "e.dcm"), ImplicitVRLittleEndian)
d = enhanced(order)
for sequence in ("SharedFunctionalGroupsSequence", "PerFrameFunctionalGroupsSequence", "SourceImageSequence"):
    d[sequence].is_undefined_length = True
    for item in d[sequence].value:
        item.is_undefined_length_sequence_item = True
save(d, os.path.join(listed("enhanced-delimited", ct, offset=-1024), "e.dcm"))

# Files without preamble and what belongs to it.
folder = listed("bare", ct, offset=-1024)
series(folder, ct, hounsfield)
for name in os.listdir(folder):
    path = os.path.join(folder, name)
    d = pydicom.dcmread(path)
    data = open(path, "rb").read()
    length = int.from_bytes(data[140:144], "little")
    open(path, "wb").write(data[144 + length:])

# --- Compressed by GDCM

if shutil.which("gdcmconv"):
    for coding, option in (("rle", "--rle"), ("jpeg", "--jpeg"), ("jpegls", "--jpegls"), ("j2k", "--j2k")):
        for source, kind in (("ct", "i2"), ("u8", "u1"), ("i12", "i2"), ("enhanced", "i2")):
            if source == "i12" and coding != "rle":
                continue  # GDCM refuses what it finds above the bits
            voxels = np.fromfile(os.path.join(root, source + ".bin"), kind).reshape(NZ, NY, NX)
            folder = listed(f"{coding}-{source}", voxels, offset=-1024 if source in ("ct", "enhanced") else 0)
            for name in os.listdir(os.path.join(root, source)):
                subprocess.run(["gdcmconv", option, os.path.join(root, source, name), os.path.join(folder, name)],
                               check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

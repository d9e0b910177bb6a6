"""Sound files of every kind that the program reads, each in a folder of its own, small and varied.

make(program, folder) -> [Case]: `arguments` run the program on the case inside its folder. What needs
another program or module that is missing (tifffile, vdb_tool) is left out and said.
"""
import collections
import gzip
import json
import os
import pathlib
import shutil
import struct
import subprocess
import tempfile
import zipfile
import zlib

Case = collections.namedtuple("Case", "kind name arguments")

MEMORY = ["--memory", "64M", "--threads", "2"]
DRAW = ["-o", "out.png", "--size", "32x32"] + MEMORY
W, H, D = 12, 10, 9


def voxels(kind="B", steps=1):
    """A ball in haze, x fastest."""
    values = []
    for t in range(steps):
        for z in range(D):
            for y in range(H):
                for x in range(W):
                    far = ((x - W / 2) ** 2 + (y - H / 2) ** 2 + (z - D / 2) ** 2) ** 0.5
                    values.append(max(0, 200 - 40 * far + t) + (x * 7 + y * 3 + z) % 5)
    if kind in "fd":
        return struct.pack(f"<{len(values)}{kind}", *values)
    return struct.pack(f"<{len(values)}{kind}", *(int(v) for v in values))


def png(path, rows, width, height, bits=8, color=0):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    row = len(rows) // height
    data = b"".join(b"\0" + rows[y * row:(y + 1) * row] for y in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, color, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b""))


def nifti(version, order, pair=False):
    size = 348 if version == 1 else 540
    h = bytearray(size + 4)

    def put(at, form, *values):
        struct.pack_into(order + form, h, at, *values)

    if version == 1:
        put(0, "i", 348)
        put(40, "8h", 3, W, H, D, 1, 1, 1, 1)
        put(70, "hh", 4, 16)
        put(76, "8f", 1, 1, 1, 2, 1, 1, 1, 1)
        put(108, "f", 0 if pair else 352)
        put(112, "ff", 2, -10)
        put(123, "b", 2)
        put(252, "hh", 1, 1)
        put(280, "12f", 1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 2, 7)
        h[344:348] = b"ni1\0" if pair else b"n+1\0"
    else:
        put(0, "i", 540)
        h[4:12] = b"n+2\0\r\n\032\n"
        put(12, "hh", 4, 16)
        put(16, "8q", 3, W, H, D, 1, 1, 1, 1)
        put(104, "8d", 1, 1, 1, 2, 1, 1, 1, 1)
        put(168, "q", 544)
        put(176, "dd", 1, 0)
        put(344, "ii", 1, 0)
        put(500, "i", 2)
    data = voxels("h") if order == "<" else struct.pack(f">{W * H * D}h", *struct.unpack(f"<{W * H * D}h", voxels("h")))
    return (bytes(h), data) if pair else (bytes(h) + data, b"")


NRRD = "NRRD0004\n# made\ntype: {type}\ndimension: 3\nsizes: 12 10 9\nendian: little\nencoding: {encoding}\n" \
       "space: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (1,2,3)\n" \
       "kinds: domain domain domain\nmin: 0\nmax: 300\n"
META = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = {compressed}\n" \
       "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 2\nDimSize = 12 10 9\n" \
       "ElementType = {type}\nElementDataFile = {file}\n"
TRANSFER = {"sluice_transfer_function": 1, "name": "n", "colors": [[0, "#000000"], [100, 0.5, 0.4, 0.3], [200, "#ffffff"]],
            "opacities": [[0, 0], [50, 0.1], [200, 0.6]], "domain": "values", "unit_length_vox": 1}
PATH = {"keys": [{"at": 0, "azimuth": 0, "elevation": 10, "zoom": 1}, {"at": 0.5, "azimuth": 90, "fov": 30},
                 {"at": 1, "azimuth": 180, "up": [0, 1, 0]}]}
PARAVIEW = [{"ColorSpace": "RGB", "Name": "p", "Points": [0, 0, 0.5, 0, 200, 1, 0.5, 0],
             "RGBPoints": [0, 0, 0, 0, 100, 1, 0, 0, 200, 1, 1, 1]}]
ZARRAY = {"zarr_format": 2, "shape": [9, 10, 12], "chunks": [4, 5, 12], "dtype": "|u1", "compressor": None, "fill_value": 0,
          "order": "C", "filters": None, "dimension_separator": "."}
OME = {"multiscales": [{"version": "0.4", "axes": [{"name": "z", "type": "space", "unit": "micrometer"},
                                                   {"name": "y", "type": "space"}, {"name": "x", "type": "space"}],
                        "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [2, 1, 1]}]}]}],
       "omero": {"channels": [{"label": "a"}]}}


class Maker:
    def __init__(self, program, root):
        self.program, self.root, self.cases = program, root, []

    def folder(self, name):
        path = self.root / name
        path.mkdir()
        return path

    def case(self, kind, name, *arguments):
        self.cases.append(Case(kind, name, list(arguments)))

    def run(self, folder, *arguments):
        environment = dict(os.environ, XDG_CACHE_HOME=str(folder / "cache"))
        subprocess.run([self.program, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL, env=environment)


def headers(m):
    for name, kind, code, encoding in (("nrrd-u8", "uchar", "B", "raw"), ("nrrd-float", "float", "f", "raw"),
                                       ("nrrd-gzip", "short", "h", "gzip"), ("nrrd-text", "int", "i", "ascii")):
        f = m.folder(name)
        data = voxels(code)
        if encoding == "gzip":
            data = gzip.compress(data)
        if encoding == "ascii":
            data = " ".join(str(v) for v in struct.unpack(f"<{W * H * D}i", data)).encode()
        (f / "v.nrrd").write_bytes((NRRD.format(type=kind, encoding=encoding) + "\n").encode() + data)
        m.case("nrrd", name, "info", "v.nrrd", *MEMORY)
    f = m.folder("nrrd-detached")
    (f / "v.nhdr").write_text(NRRD.format(type="uchar", encoding="raw") + "data file: s%d.raw 0 8 1 2\n")
    for z in range(D):
        (f / f"s{z}.raw").write_bytes(voxels()[z * W * H:(z + 1) * W * H])
    m.case("nrrd", "nrrd-detached", "render", "v.nhdr", *DRAW)
    f = m.folder("meta-local")
    (f / "v.mha").write_bytes(META.format(compressed="False", type="MET_SHORT", file="LOCAL").encode() + voxels("h"))
    m.case("meta", "meta-local", "info", "v.mha", *MEMORY)
    f = m.folder("meta-packed")
    (f / "v.mhd").write_text(META.format(compressed="True", type="MET_UCHAR", file="v.zraw"))
    (f / "v.zraw").write_bytes(zlib.compress(voxels()))
    m.case("meta", "meta-packed", "render", "v.mhd", *DRAW)
    for version, order in ((1, "<"), (1, ">"), (2, "<")):
        name = f"nifti{version}-{'little' if order == '<' else 'big'}"
        f = m.folder(name)
        (f / "v.nii").write_bytes(nifti(version, order)[0])
        m.case("nifti", name, "info", "v.nii", *MEMORY)
    f = m.folder("nifti-gz")
    (f / "v.nii.gz").write_bytes(gzip.compress(nifti(1, "<")[0]))
    m.case("nifti", "nifti-gz", "render", "v.nii.gz", *DRAW)
    f = m.folder("nifti-pair")
    header, data = nifti(1, "<", pair=True)
    (f / "v.hdr").write_bytes(header)
    (f / "v.img").write_bytes(data)
    m.case("nifti", "nifti-pair", "info", "v.hdr", *MEMORY)
    f = m.folder("raw")
    (f / "v_12x10x9_float32.raw").write_bytes(voxels("f"))
    m.case("raw", "raw", "render", "v_12x10x9_float32.raw", *DRAW)
    f = m.folder("raw-slices") / "scan"
    f.mkdir()
    for z in range(D):
        (f / f"s{z}").write_bytes(voxels("H")[2 * z * W * H:2 * (z + 1) * W * H])
    m.case("raw", "raw-slices", "info", "scan", "--dims", f"{W},{H},{D}", "--type", "u16", *MEMORY)
    f = m.folder("series")
    for t in range(3):
        (f / f"t{t}.nrrd").write_bytes((NRRD.format(type="uchar", encoding="raw") + "\n").encode() + voxels())
    m.case("nrrd", "series", "info", "t%d.nrrd", "--time", "2", *MEMORY)


def slices(m):
    f = m.folder("png")
    for z in range(D):
        png(f / f"s{z}.png", voxels()[z * W * H:(z + 1) * W * H], W, H)
    m.case("png", "png", "render", ".", *DRAW)
    f = m.folder("png-rgba16")
    for z in range(3):
        png(f / f"s{z}.png", bytes((i * 37) % 256 for i in range(W * H * 8)), W, H, 16, 6)
    m.case("png", "png-rgba16", "info", "s*.png", *MEMORY)
    try:
        import numpy
        import tifffile
    except ImportError:
        print("no TIFF files: numpy or tifffile is missing")
        return
    stack = numpy.frombuffer(voxels("H"), "<u2").reshape(D, H, W)
    kinds = (("plain", dict(rowsperstrip=3)), ("zlib", dict(compression="zlib", rowsperstrip=4)),
             ("tiles", dict(tile=(16, 16))), ("big-endian", dict(byteorder=">", bigtiff=True)))
    for name, options in kinds:
        f = m.folder("tiff-" + name)
        for z in range(4):
            tifffile.imwrite(f / f"s{z}.tif", stack[z], photometric="minisblack", **options)
        m.case("tiff", "tiff-" + name, "info", ".", *MEMORY)
    hyper = numpy.stack([stack, stack]).reshape(1, 2, D, 1, H, W).transpose(0, 2, 1, 3, 4, 5).reshape(1, D, 2, H, W)
    f = m.folder("tiff-imagej")
    tifffile.imwrite(f / "v.tif", hyper, imagej=True, resolution=(2, 2),
                     metadata={"axes": "TZCYX", "spacing": 2, "unit": "um"}, truncate=True)
    m.case("tiff", "tiff-imagej", "info", "v.tif", "--channel", "1", *MEMORY)
    f = m.folder("tiff-ome")
    tifffile.imwrite(f / "v.tif", hyper, ome=True, photometric="minisblack",
                     metadata={"axes": "TZCYX", "PhysicalSizeX": 0.5, "PhysicalSizeXUnit": "µm"})
    m.case("tiff", "tiff-ome", "render", "v.tif", *DRAW)


def zarrs(m):
    def store(name, array, image=None, codec=None, chunks=True):
        f = m.folder(name) / "v.zarr"
        inside = f / "0" if image else f
        inside.mkdir(parents=True)
        if image:
            (f / ".zgroup").write_text('{"zarr_format": 2}')
            (f / ".zattrs").write_text(json.dumps(image))
        (inside / ".zarray").write_text(json.dumps(array))
        for z in range(3 if chunks else 0):
            for y in range(2):
                data = bytes((z * 40 + y * 20 + i) % 256 for i in range(4 * 5 * 12))
                (inside / f"{z}.{y}.0").write_bytes(codec(data) if codec else data)

    store("zarr-plain", ZARRAY)
    store("zarr-ome", dict(ZARRAY, compressor={"id": "zlib", "level": 1}), OME, zlib.compress)
    store("zarr-none", dict(ZARRAY, dtype="<f4", fill_value="NaN"), chunks=False)
    store("zarr-gzip", dict(ZARRAY, compressor={"id": "gzip", "level": 1}), None, gzip.compress)
    m.case("zarr", "zarr-plain", "info", "v.zarr", *MEMORY)
    m.case("zarr", "zarr-ome", "render", "v.zarr", *DRAW)
    m.case("zarr", "zarr-none", "info", "v.zarr", *MEMORY)
    m.case("zarr", "zarr-gzip", "info", "v.zarr/", *MEMORY)
    f = m.folder("zarr-packed")
    m.run(f, "pack", "synth:shells,dims=20x20x20", "-o", "v.zarr", "--codec", "zstd")
    m.case("zarr", "zarr-packed", "render", "v.zarr", *DRAW)
    for name, method in ("stored", zipfile.ZIP_STORED), ("deflated", zipfile.ZIP_DEFLATED):
        with zipfile.ZipFile(m.folder(f"zip-{name}") / "v.zip", "w", method) as out:
            for path in sorted((f / "v.zarr").rglob("*")):
                if path.is_file():
                    out.write(path, path.relative_to(f))
        m.case("zip", f"zip-{name}", "render", "v.zip", *DRAW)
    f = m.folder("zarr-shards")
    m.run(f, "pack", "synth:shells,dims=20x20x20", "-o", "v.zarr", "--zarr", "3", "--chunk", "8", "--shard", "16", "--levels", "1")
    m.case("zarr", "zarr-shards", "render", "v.zarr", *DRAW)
    with tempfile.TemporaryDirectory() as made:
        script = pathlib.Path(__file__).parents[1] / "io/make_zarr3.py"
        if subprocess.run(["/usr/bin/python3", script, made], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            return  # NumPy or numcodecs is missing
        for name in ("zstd_True", "shard_blosc_False", "index_end_True_little", "image"):
            shutil.copytree(pathlib.Path(made) / name, m.folder(f"zarr3-{name}") / "v.zarr")
            m.case("zarr", f"zarr3-{name}", "info" if name == "zstd_True" else "render", "v.zarr", *(MEMORY if name == "zstd_True" else DRAW))


def n5(m):
    with tempfile.TemporaryDirectory() as made:
        script = pathlib.Path(__file__).parents[1] / "io/make_n5.py"
        if subprocess.run(["/usr/bin/python3", script, made], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            print("no N5 groups: numpy or zarr is missing")
            return
        for name in ("cut_uint16", "zstd_1", "blosc_0", "scales"):
            shutil.copytree(pathlib.Path(made) / name, m.folder(f"n5-{name}") / "v.n5")
            m.case("n5", f"n5-{name}", "render", "v.n5", *DRAW)


def vtk(m):
    with tempfile.TemporaryDirectory() as made:
        script = pathlib.Path(__file__).parents[1] / "io/make_vtk.py"
        if subprocess.run(["/usr/bin/python3", script, made], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            print("no VTK images: numpy or VTK's modules are missing")
            return
        for name in ("raw_uint8.vti", "ascii_int16.vti", "base64_float32.vti", "zlib_uint16.vti", "appendedTrueLZ4FalseTrue512.vti", "cells.vti",
                     "legacy_int16_False.vtk", "several_True_third.vtk"):
            end = name[-4:]
            shutil.copy(pathlib.Path(made) / name, m.folder("vtk-" + name.replace(".", "-")) / ("v" + end))
            m.case("vtk", "vtk-" + name.replace(".", "-"), "render", "v" + end, *DRAW)


def hdf5(m):
    with tempfile.TemporaryDirectory() as made:
        for script in ("make_hdf5.py", "make_microscopes.py"):
            folder = pathlib.Path(made) / script
            folder.mkdir()
            script = pathlib.Path(__file__).parents[1] / "io" / script
            if subprocess.run(["/usr/bin/python3", script, folder], stderr=subprocess.DEVNULL, check=False).returncode != 0:
                print("no HDF5 files: h5py or zarr is missing")
                return
        for folder, name in (("make_hdf5.py", "one.h5"), ("make_hdf5.py", "block.h5"), ("make_microscopes.py", "image.ims"), ("make_microscopes.py", "hdf5.xml")):
            place = m.folder("hdf5-" + name.replace(".", "-"))
            shutil.copy(pathlib.Path(made) / folder / name, place / name)
            if name.endswith("xml"):
                shutil.copy(pathlib.Path(made) / folder / "bdv.h5", place)
            m.case("hdf5", place.name, "render", name, *DRAW)


def tiff_sets(m):
    """OME-TIFF files that belong together, by the XML in each or in a companion, and pages with reduced images."""
    with tempfile.TemporaryDirectory() as made:
        script = pathlib.Path(__file__).parents[1] / "io/make_tiff_pages.py"
        if subprocess.run(["/usr/bin/python3", script, made], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            print("no sets of TIFF files: numpy or tifffile is missing")
            return
        for name, opened, arguments in (("ome-set", "ome-set-1.tif", DRAW), ("ome-companion", "ome-companion.tif", DRAW),
                                        ("ome-companion", "ome-companion-2.tif", MEMORY),
                                        ("levels-means", "levels-means.tif", MEMORY)):
            place = m.folder("set-" + opened.replace(".", "-"))
            for file in pathlib.Path(made).glob(name + "*"):
                if file.suffix != ".bin":
                    shutil.copy(file, place)
            m.case("ome", place.name, "render" if arguments is DRAW else "info", opened, *arguments)


def vdbs(m):
    def tool(*arguments):
        try:
            subprocess.run(["vdb_tool", "-quiet", *arguments], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        except (OSError, subprocess.CalledProcessError):
            return False
        return True

    f = m.folder("vdb-fog")
    if not tool("-sphere", "dim=24", "radius=1", "-ls2fog", "-write", str(f / "v.vdb")):
        print("no OpenVDB files: vdb_tool is missing")
        return
    m.case("vdb", "vdb-fog", "render", "v.vdb", *DRAW)
    f = m.folder("vdb-level-set")
    tool("-sphere", "dim=16", "radius=1", "-write", str(f / "v.vdb"))
    m.case("vdb", "vdb-level-set", "info", "v.vdb", *MEMORY)
    f = m.folder("vdb-series")
    for t in range(3):
        tool("-sphere", f"dim={10 + 4 * t}", "radius=1", "voxel=0.2", "-ls2fog", "-write", str(f / f"t{t}.vdb"))
    m.case("vdb", "vdb-series", "info", "t%d.vdb", "--time", "2", *MEMORY)


def dicoms(m):
    with tempfile.TemporaryDirectory() as made:
        script = pathlib.Path(__file__).parents[1] / "io/make_dicom.py"
        if subprocess.run(["/usr/bin/python3", script, made], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            print("no DICOM files: NumPy or pydicom is missing")
            return
        for name in ("ct", "implicit", "several", "times", "missing", "tilt", "folders", "enhanced", "enhanced-delimited", "dose", "rle-ct", "jpeg-ct",
                     "jpegls-u8", "j2k-ct"):
            folder = pathlib.Path(made) / name
            if not folder.exists():
                continue  # GDCM's programs are missing
            shutil.copytree(folder, m.folder(f"dicom-{name}") / "scan")
            drawn = name in ("ct", "jpeg-ct", "j2k-ct")
            m.case("dicom", f"dicom-{name}", "render" if drawn else "info", "scan", *(DRAW if drawn else MEMORY))


def others(m):
    volume = "v_12x10x9_uint8.raw"

    def beside(name):
        f = m.folder(name)
        (f / volume).write_bytes(voxels())
        return f

    for name, content in (("transfer", TRANSFER), ("paraview", PARAVIEW)):
        f = beside(name)
        (f / "t.json").write_text(json.dumps(content))
        m.case("json", name, "render", volume, "--transfer", "t.json", *DRAW)
    f = beside("path")
    (f / "p.json").write_text(json.dumps(PATH))
    m.case("json", "path", "render", volume, "--path", "p.json", "--frames", "2", "-o", "out.png", "--size", "16x16", *MEMORY)
    f = beside("index")
    m.run(f, "info", volume, "--block", "8")
    m.case("index", "index", "info", volume, "--block", "8", *MEMORY)
    f = beside("boxes")
    m.run(f, "render", volume, "--partition", "boxes", "--block", "8", "-o", "out.png", "--size", "16x16")
    m.case("index", "boxes", "render", volume, "--partition", "boxes", "--block", "8", *DRAW)
    for end in ("bin", "txt", "csv", "din", "oracleGeneral"):
        f = m.folder("trace-" + end)
        m.run(f, "render", "synth:shells,dims=40x40x40", "-o", "out.png", "--size", "16x16", "--frames", "2", "--block", "16",
              "--page", "8x8x8", "--pages", "256", "--trace", "t." + end)
        for picture in f.glob("out*.png"):
            picture.unlink()
        m.case("trace", "trace-" + end, "simulate", "t." + end, "--sizes", "256", "--policies", "lru,arc")


def make(program, root):
    maker = Maker(program, root)
    for part in (headers, slices, zarrs, n5, vtk, hdf5, tiff_sets, vdbs, dicoms, others):
        part(maker)
    return maker.cases

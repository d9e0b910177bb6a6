"""Changes to sound files at the joints of their formats. apply(rng, kind, folder) changes one file of the
folder in place and says in a few words what it did."""
import gzip
import json
import random
import re
import struct
import zlib

# Numbers that catch arithmetic: ends of types, signs, what no type holds.
WHOLE = [0, 1, -1, 2, 3, 7, 255, 256, 65535, 65536, 2**31 - 1, 2**31, -2**31, 2**32 - 1, 2**32, 2**53, 2**62, 2**63 - 1, 2**63,
         -2**63, 2**64, 10**6, 10**9, 10**18, 10**30]
TEXTS = [str(n) for n in WHOLE] + ["", "-", "+", ".", "1e300", "-1e300", "1e308", "1e-300", "5e-324", "1e999", "nan", "inf", "-inf",
                                   "0x10", "1e30", "1e31", "%d", "%s%n", "\x1b[31mred\x07", "../x", "/etc/passwd", "/dev/zero", "LOCAL", "LIST",
                                   "none", "True", "a" * 5000, "\u00e9\u4e2d", "1 2 3 4 5", "(1,0,0)", "\0", "v.nrrd", "."]
JSONS = [None, True, False, 0, -1, 1, 0.5, 1e300, -1e300, 1e-300, 2**31, 2**53, 2**63, "", "NaN", "Infinity", "a\x1b[31m", "../..", "/dev/zero",
         [], {}, [[]], [0], [1, 2, 3], {"a": 1}, "x" * 3000]


def apply(rng, kind, folder):
    files = sorted(p for p in folder.rglob("*") if p.is_file() and "cache" not in p.parts and p.name != "stderr" and not p.name.startswith("out"))
    if kind == "index":
        files = [p for p in files if p.suffix in (".idx",)] or files
        files += sorted(p for p in (folder / "cache").rglob("*") if p.is_file())
    if kind == "json":
        files = [p for p in files if p.suffix == ".json"]
    path = rng.choice(files)
    ways = {"nrrd": [text_field], "meta": [text_field], "nifti": [nifti_field], "tiff": [tiff_tag, tiff_tag, tiff_text], "png": [png_header, png_chunk],
            "zarr": [json_member, json_member], "n5": [json_member, json_member, words], "zip": [words, words], "ome": [tiff_tag, tiff_text, xml_value, xml_value], "vtk": [text_field, xml_value, words], "hdf5": [words, words, xml_value], "json": [json_member, json_member, json_text], "vdb": [vdb_field, vdb_field, words], "dicom": [dicom_element, dicom_element, words], "index": [words], "trace": [text_field, words],
            "raw": [words]}[kind]
    way = rng.choice(ways + [damage])
    if rng.random() < 0.03:
        way = missing
    try:
        said = way(rng, path)
    except (ValueError, IndexError, struct.error, OSError, zlib.error, EOFError, RecursionError):  # deeply nested JSON
        said = None
    return f"{path.name}: {said or damage(rng, path)}"


def missing(rng, path):
    path.unlink()
    if rng.random() < 0.5:
        path.mkdir()
        return "a folder in its place"
    return "missing"


def damage(rng, path):
    """Bytes anywhere, a cut, a doubled or dropped part."""
    data = bytearray(path.read_bytes())
    if not data:
        path.write_bytes(bytes(rng.randrange(256) for _ in range(rng.randrange(1, 400))))
        return "noise where nothing was"
    way = rng.randrange(6)
    if way == 0:
        del data[rng.randrange(len(data)):]
        said = f"cut to {len(data)}"
    elif way == 1:
        at = rng.randrange(len(data))
        data[at:at] = bytes(rng.randrange(256) for _ in range(rng.randrange(1, 40)))
        said = f"bytes put in at {at}"
    elif way == 2:
        at, length = rng.randrange(len(data)), rng.randrange(1, 64)
        del data[at:at + length]
        said = f"{length} bytes taken out at {at}"
    else:
        front = min(len(data), 600) if rng.random() < 0.7 else len(data)
        places = sorted(rng.randrange(front) for _ in range(rng.randrange(1, 6)))
        for at in places:
            data[at] = rng.choice([0, 1, 0x7f, 0x80, 0xff, rng.randrange(256)])
        said = f"bytes changed at {places}"
    path.write_bytes(data)
    return said


def words(rng, path):
    """Numbers of 2, 4 or 8 bytes in either order, most often near the front."""
    data = bytearray(path.read_bytes())
    said = []
    for _ in range(rng.randrange(1, 3)):
        size = rng.choice([2, 4, 8])
        end = min(len(data), 800) if rng.random() < 0.6 else len(data)
        at = rng.randrange(max(1, end - size))
        value = rng.choice(WHOLE) % 256**size
        if rng.random() < 0.2:
            data[at:at + 8] = struct.pack("<d", rng.choice([float("nan"), float("inf"), 1e300, -1e308, 5e-324]))
        else:
            data[at:at + size] = value.to_bytes(size, rng.choice(["little", "big"]))
        said.append(f"{value} in {size} bytes at {at}")
    path.write_bytes(data)
    return ", ".join(said)


def text_field(rng, path):
    """A value of a header, or one of its words, becomes another; lines are doubled, dropped, swapped."""
    data = path.read_bytes()
    end = data.find(b"\n\n")
    end = end if 0 < end < 4000 else min(len(data), 2000)
    head, rest = data[:end].decode("latin-1"), data[end:]
    lines = head.split("\n")
    at = rng.randrange(len(lines))
    way = rng.randrange(8)
    if way == 0:
        lines.insert(at, lines[at])
    elif way == 1:
        del lines[at]
    elif way == 2:
        lines.insert(at, rng.choice(TEXTS))
    else:
        separator = next((s for s in (":", "=", ",", " ") if s in lines[at]), None)
        if separator is None:
            lines[at] = rng.choice(TEXTS)
        else:
            key, value = lines[at].split(separator, 1)
            parts = value.split()
            if parts and way > 4:
                parts[rng.randrange(len(parts))] = rng.choice(TEXTS)
                value = " " + " ".join(parts)
            else:
                value = " " + rng.choice(TEXTS)
            lines[at] = key + separator + value
    path.write_bytes("\n".join(lines).encode("utf-8", "surrogateescape") + rest)
    return f"header line {at}: {lines[min(at, len(lines) - 1)][:60]!r}" if lines else "no header"


# Offset and form of each field of the two versions.
NIFTI1 = [(0, "i"), (40, "h"), (42, "h"), (44, "h"), (46, "h"), (48, "h"), (50, "h"), (70, "h"), (72, "h"), (76, "f"), (80, "f"), (84, "f"), (88, "f"),
          (108, "f"), (112, "f"), (116, "f"), (123, "b"), (252, "h"), (254, "h"), (256, "f"), (268, "f"), (280, "f"), (284, "f"), (292, "f"), (324, "f")]
NIFTI2 = [(0, "i"), (12, "h"), (14, "h"), (16, "q"), (24, "q"), (32, "q"), (40, "q"), (48, "q"), (104, "d"), (112, "d"), (128, "d"), (168, "q"),
          (176, "d"), (184, "d"), (344, "i"), (348, "i"), (352, "d"), (376, "d"), (400, "d"), (500, "i")]


def nifti_field(rng, path):
    data = path.read_bytes()
    packed = data[:2] == b"\x1f\x8b"
    data = bytearray(gzip.decompress(data) if packed else data)
    order = "<" if data[0] in (0x5c, 0x1c) else ">"
    first = struct.unpack_from(order + "i", data)[0]
    if first not in (348, 540):
        return None
    said = []
    for _ in range(rng.randrange(1, 3)):
        at, form = rng.choice(NIFTI1 if first == 348 else NIFTI2)
        if form in "fd":
            value = rng.choice([0, -1, 1e38, -1e38, 1e300, 1e-38, float("nan"), float("inf"), 0.5, 353.5, 1e10])
            if form == "f" and abs(value) > 3e38:
                value = float("inf")
        else:
            bits = 8 * struct.calcsize(order + form)
            value = rng.choice(WHOLE) % 2**bits
            value -= 2**bits if value >= 2**(bits - 1) else 0
        struct.pack_into(order + form, data, at, value)
        said.append(f"{value} at {at}")
    path.write_bytes(gzip.compress(bytes(data)) if packed else data)
    return ", ".join(said)


def tiff_tag(rng, path):
    """A tag's type, count or value, or the place of a directory."""
    data = bytearray(path.read_bytes())
    order = "<" if data[:1] == b"I" else ">"
    big = struct.unpack_from(order + "H", data, 2)[0] == 43
    at = struct.unpack_from(order + ("Q" if big else "I"), data, 8 if big else 4)[0]
    for _ in range(rng.randrange(3)):  # a later page perhaps
        count = struct.unpack_from(order + ("Q" if big else "H"), data, at)[0]
        following = struct.unpack_from(order + ("Q" if big else "I"), data, at + (8 if big else 2) + count * (20 if big else 12))[0]
        if following == 0:
            break
        at = following
    count = struct.unpack_from(order + ("Q" if big else "H"), data, at)[0]
    first = at + (8 if big else 2)
    size = 20 if big else 12
    if rng.random() < 0.1:
        struct.pack_into(order + ("Q" if big else "I"), data, first + count * size, rng.choice([at, 1, 8, len(data), 2**32 - 1, 0]))
        path.write_bytes(data)
        return "the place of the next page"
    entry = first + rng.randrange(count) * size
    tag = struct.unpack_from(order + "H", data, entry)[0]
    where, form = rng.choice([(0, "H"), (2, "H"), (4, "Q" if big else "I"), (12 if big else 8, "Q" if big else "I"), (12 if big else 8, "H"),
                              (12 if big else 8, "H")])
    value = rng.choice(WHOLE + [1, 2, 4, 8, 16, 32, 64, 5, 6, 7, 32773, 8 << 16]) % 256**struct.calcsize(order + form)
    struct.pack_into(order + form, data, entry + where, value)
    path.write_bytes(data)
    return f"tag {tag}: {value} at {where}"


def dicom_element(rng, path):
    """The length, the type or the value of an element that names its type."""
    data = bytearray(path.read_bytes())
    found = [m.start() for m in re.finditer(rb"[\x02\x08\x18\x20\x28\x52\xe0]\x00..(CS|DS|IS|US|UI|OW|OB|SQ|PN|SH|LO)", bytes(data), re.S)]
    found += [m.start() for m in re.finditer(rb"\xfe\xff(\x00\xe0|\x0d\xe0|\xdd\xe0)", bytes(data))]
    at = rng.choice(found)
    way = rng.randrange(4)
    if way == 0:
        struct.pack_into("<H", data, at + 6, rng.choice(WHOLE) % 2**16)
        said = "length"
    elif way == 1:
        struct.pack_into("<I", data, at + 8, rng.choice(WHOLE) % 2**32)
        said = "value or long length"
    elif way == 2:
        data[at + 4:at + 6] = rng.choice([b"SQ", b"UN", b"OB", b"US", b"DS", b"\0\0", b"zz"])
        said = "type"
    else:
        for i in range(at + 8, min(at + 8 + rng.randrange(1, 12), len(data))):
            data[i] = rng.choice(b"0123456789.-+e\\\0 ")
        said = "value"
    path.write_bytes(data)
    return f"{said} of the element at {at}"


def tiff_text(rng, path):
    """A number or word of the description, of the same length."""
    data = path.read_bytes()
    at = max(data.find(b"ImageJ="), data.find(b"<?xml"))
    if at < 0:
        return None
    end = data.find(b"\0", at)
    places = [i for i in range(at, end) if chr(data[i]).isdigit() or chr(data[i]).isalpha()]
    changed = bytearray(data)
    for _ in range(rng.randrange(1, 4)):
        changed[rng.choice(places)] = rng.choice(b"0123456789-e<>\"' \x1bZCT")
    path.write_bytes(changed)
    return "the description"


XML_TEXTS = ["", "0", "-1", "1", "2", "3", "255", "4294967296", "9223372036854775808", "1e300", "nan", "0.5", "XYZCT", "XYCZT", "XXXXX", "uint8", "uint16",
             "double", "Int16", "&amp;", "&lt;&#27;[2J", "&#0;", "&nothing;", "../other.tif", "/dev/zero", "v.tif", "0 5 0 5 0 5", "1 1 1", "a" * 3000]


def xml_value(rng, path):
    """The value of an attribute, or the text of an element; of a TIFF's description in as many bytes."""
    data = path.read_bytes()
    begin = data.find(b"<")
    if path.suffix == ".tif":
        begin = data.find(b"<OME")
    end = data.find(b"\0", begin) if path.suffix == ".tif" else len(data)
    found = list(re.finditer(rb'(?<==")[^"]*(?=")|(?<=>)[^<>]+(?=<)', data[begin:end]))
    place = rng.choice(found)
    at, length = begin + place.start(), len(place.group())
    value = rng.choice(XML_TEXTS).encode()
    if path.suffix == ".tif":
        value = value[:length].ljust(length)
    path.write_bytes(data[:at] + value + data[at + length:])
    return f"{place.group()[:30]!r} becomes {value[:30]!r}"


def chunks_of(data):
    at, found = 8, []
    while at + 12 <= len(data):
        length = struct.unpack_from(">I", data, at)[0]
        found.append((data[at + 4:at + 8], data[at + 8:at + 8 + length]))
        at += 12 + length
    return found


def write_png(path, chunks):
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(d)) + n + d + struct.pack(">I", zlib.crc32(n + d)) for n, d in chunks))


def png_header(rng, path):
    """With right check sums, so that what is behind them is reached."""
    chunks = chunks_of(path.read_bytes())
    fields = list(struct.unpack(">IIBBBBB", chunks[0][1]))
    which = rng.randrange(7)
    fields[which] = rng.choice([0, 1, 12, 13, 1000, 10**6, 10**6 + 1, 2**31 - 1, 2**32 - 1]) if which < 2 else rng.choice([0, 1, 2, 3, 4, 6, 8, 16, 255])
    chunks[0] = (b"IHDR", struct.pack(">IIBBBBB", *fields))
    write_png(path, chunks)
    return f"IHDR {fields}"


def png_chunk(rng, path):
    chunks = chunks_of(path.read_bytes())
    way = rng.randrange(5)
    at = rng.randrange(len(chunks))
    if way == 0:
        chunks.insert(at, chunks[at])
    elif way == 1:
        del chunks[at]
    elif way == 2:
        chunks.insert(at, (rng.choice([b"tEXt", b"PLTE", b"tRNS", b"acTL", b"zTXt", b"iCCP", b"IDAT"]), bytes(rng.randrange(256) for _ in range(30))))
    elif way == 3:
        chunks[at] = (chunks[at][0], chunks[at][1][:rng.randrange(len(chunks[at][1]) + 1)])
    else:
        data = bytearray(zlib.decompress(b"".join(d for n, d in chunks if n == b"IDAT")))
        data = data[:rng.randrange(len(data))] if rng.random() < 0.5 else data + bytes(5000)
        chunks = [c for c in chunks if c[0] != b"IDAT"]
        chunks.insert(1, (b"IDAT", zlib.compress(bytes(data))))
    write_png(path, chunks)
    return f"chunks, way {way}"


def members(value, found):
    if isinstance(value, dict):
        for key in value:
            found.append((value, key))
            members(value[key], found)
    if isinstance(value, list):
        for i in range(len(value)):
            found.append((value, i))
            members(value[i], found)
    return found


VDB_TEXTS = ["", "float", "int32", "vec3i", "string", "bool", "density", "Tree_float_5_4_3", "Tree_float_5_4_3_HalfFloat", "Tree_vec3s_5_4_3",
             "Tree_half_5_4_3", "Tree_float_5_4", "Tree_uint32_5_4_3", "PointDataGrid", "level set", "fog volume", "staggered", "fog", "AffineMap",
             "ScaleMap", "UniformScaleTranslateMap", "TranslationMap", "NonlinearFrustumMap", "UnitaryMap", "a\x1eb", "class", "file_bbox_min"]


class VdbHeader:
    """The head of an OpenVDB file of one grid, taken apart, so that a part may change its length."""

    def __init__(self, data):
        self.data, self.at = data, 0
        self.front = self.take(57)
        self.file_metadata = self.metadata()
        if self.number("I") != 1:
            raise ValueError("several grids")
        self.texts = [self.text() for _ in range(3)]  # name, type, shared tree
        self.places = [self.number("Q") for _ in range(3)]
        self.compression = self.number("I")
        self.grid_metadata = self.metadata()
        self.transform = self.text()
        self.numbers = [self.number("d") for _ in range({"AffineMap": 16, "UniformScaleMap": 15, "UniformScaleTranslateMap": 18,
                                                         "ScaleMap": 15, "ScaleTranslateMap": 18}[self.transform.decode()])]

    def take(self, count):
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, form):
        return struct.unpack("<" + form, self.take(struct.calcsize("<" + form)))[0]

    def text(self):
        return self.take(self.number("I"))

    def metadata(self):
        return [[self.text(), self.text(), self.text()] for _ in range(self.number("I"))]

    def bytes(self):
        def text(t):
            return struct.pack("<I", len(t)) + t

        def metadata(entries):
            return struct.pack("<I", len(entries)) + b"".join(text(part) for entry in entries for part in entry)

        def head(places):
            return self.front + metadata(self.file_metadata) + struct.pack("<I", 1) + b"".join(map(text, self.texts)) + struct.pack("<3Q", *places)

        grid_at = len(head([0, 0, 0]))
        grid = struct.pack("<I", self.compression) + metadata(self.grid_metadata) + text(self.transform) + struct.pack(
            f"<{len(self.numbers)}d", *self.numbers)
        moved = grid_at + len(grid) - self.at
        return head([grid_at, self.places[1] + moved, self.places[2] + moved]) + grid + self.data[self.at:]


def vdb_field(rng, path):
    """A text, a metadatum, a number of the transform or the compression of an OpenVDB file, all else in its place."""
    header = VdbHeader(path.read_bytes())
    way = rng.randrange(8)
    entries = header.grid_metadata if rng.random() < 0.8 else header.file_metadata
    other = rng.choice(VDB_TEXTS + TEXTS).encode("utf-8")
    if way == 0:
        at = rng.randrange(3)
        header.texts[at], said = other, f"text {at}"
    elif way == 1:
        at = rng.randrange(len(header.numbers))
        header.numbers[at] = rng.choice([0, -1, 1e-300, 1e300, float("nan"), float("inf"), -0.5, 3])
        said = f"number {at} of the transform: {header.numbers[at]}"
    elif way == 2:
        header.compression = rng.choice([0, 1, 2, 3, 4, 5, 6, 7, 8, 255, 2**31])
        said = f"compression {header.compression}"
    elif way == 3:
        header.transform, said = other, "transform"
    elif not entries or way == 4:
        entries.append([rng.choice(entries)[0] if entries else b"class", b"string", other])
        said = "a metadatum twice"
    elif way == 5:
        said = f"without metadatum {entries.pop(rng.randrange(len(entries)))[0]}"
    else:
        entry = rng.choice(entries)
        part = rng.randrange(3)
        said = f"{'key type value'.split()[part]} of metadatum {entry[0]}"
        entry[part] = bytes(rng.randrange(256) for _ in entry[part]) if rng.random() < 0.3 else other
    path.write_bytes(header.bytes())
    return f"{said}: {other[:40]!r}" if way in (0, 3) or way > 5 else said


def json_member(rng, path):
    """A member becomes another value, is dropped, is doubled or gets another name."""
    try:
        document = json.loads(path.read_text())
    except (UnicodeDecodeError, ValueError):
        return None
    said = []
    for _ in range(rng.randrange(1, 3)):
        places = members(document, [])
        if not places:
            break
        where, key = rng.choice(places)
        way = rng.randrange(10)
        if way == 0:
            del where[key]
        elif way == 1 and isinstance(where, dict):
            where[rng.choice(["x", "", "\x1b[2J", "a" * 200])] = where.pop(key)
        elif way == 2 and isinstance(where, list):
            where.extend([where[key]] * rng.choice([1, 5, 1000]))
        elif way < 6 and isinstance(where[key], (int, float)):
            where[key] = rng.choice(WHOLE + [0.5, 1e300, -1e300, 1e-300])
        else:
            where[key] = rng.choice(JSONS)
        said.append(str(key)[:20])
    path.write_text(json.dumps(document))
    return "members " + ", ".join(said)


def json_text(rng, path):
    """Below the level of members: keys twice, deep nests, words that JSON has not."""
    text = path.read_text()
    at = rng.randrange(len(text))
    put = rng.choice(["{", "}", "[" * 100, "\"", "NaN", "1e999", ",", "\x1b", "\u0000", "\"a\":1,\"a\":1,", "//", "-"])
    path.write_text(text[:at] + put + text[at + rng.randrange(3):])
    return f"{put[:10]!r} at {at}"

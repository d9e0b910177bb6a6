"""read_exr.py FILE OUT: the pixels of a zip-compressed scan-line EXR as f32, channel after channel.

Written from the format's description, so that our writer is checked by something else. Prints the
channels with their types, and the string attributes, a line each.
"""

import struct
import sys
import zlib

import numpy as np

data = open(sys.argv[1], "rb").read()
assert data[:8] == bytes([0x76, 0x2F, 0x31, 0x01, 2, 0, 0, 0]), data[:8]
at = 8


def text():
    global at
    end = data.index(b"\0", at)
    word, at = data[at:end].decode(), end + 1
    return word


channels = []
while data[at] != 0:
    key, kind = text(), text()
    (size,) = struct.unpack_from("<i", data, at)
    value, at = data[at + 4:at + 4 + size], at + 4 + size
    if key == "channels":
        while value[0]:
            end = value.index(b"\0")
            channels.append((value[:end].decode(), struct.unpack_from("<i", value, end + 1)[0]))
            value = value[end + 17:]
    elif key == "dataWindow":
        x0, y0, x1, y1 = struct.unpack("<4i", value)
    elif key == "compression":
        assert value[0] == 3, "zip"
    elif kind == "string":
        print("attribute", key, value.decode())
at += 1
width, height = x1 - x0 + 1, y1 - y0 + 1
pixels = {name: np.zeros((height, width), "f4") for name, kind in channels}
for n in range((height + 15) // 16):
    (chunk,) = struct.unpack_from("<Q", data, at + 8 * n)
    y, size = struct.unpack_from("<ii", data, chunk)
    rows = min(16, height - (y - y0))
    row_bytes = sum({1: 2, 2: 4}[kind] for name, kind in channels) * width
    stored = data[chunk + 8:chunk + 8 + size]
    if size < rows * row_bytes:
        deltas = np.frombuffer(zlib.decompress(stored), "u1").astype("u4")
        deltas[1:] += 256 - 128
        merged = (np.cumsum(deltas) % 256).astype("u1")
        half = (len(merged) + 1) // 2
        plain = np.empty_like(merged)
        plain[0::2], plain[1::2] = merged[:half], merged[half:]
        stored = plain.tobytes()
    offset = 0
    for row in range(rows):
        for name, kind in channels:
            step = {1: 2, 2: 4}[kind]
            line = stored[offset:offset + step * width]
            pixels[name][y - y0 + row] = np.frombuffer(line, "<f2" if kind == 1 else "<f4")
            offset += step * width
for name, kind in channels:
    print("channel", name, {1: "half", 2: "float"}[kind])
with open(sys.argv[2], "wb") as out:
    for name, kind in channels:
        out.write(pixels[name].tobytes())

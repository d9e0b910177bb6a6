"""What the tests of the Python package share: the program, the package, and small volumes.

Each test is called as NAME_test.py PROGRAM PACKAGE_FOLDER [unittest's arguments].
"""
import gzip
import os
import pathlib
import struct
import sys
import unittest
import zlib

import numpy

PROGRAM, PACKAGE = sys.argv[1:3]
sys.path.insert(0, PACKAGE)
os.environ['SLUICE_INDEX'] = 'off'
import sluice  # noqa: E402

PHANTOM = 'synth:phantom,dims=64x64x48'


def read_png(path):
    """The pixels of a PNG of 8 bits, RGB or RGBA, by its specification."""
    data = pathlib.Path(path).read_bytes()
    at, packed = 8, b''
    while at < len(data):
        size, kind = struct.unpack_from('>I4s', data, at)
        body = data[at + 8:at + 8 + size]
        if kind == b'IHDR':
            width, height, _, color = struct.unpack_from('>IIBB', body)
        elif kind == b'IDAT':
            packed += body
        at += 12 + size
    channels = {2: 3, 6: 4}[color]
    rows = numpy.frombuffer(zlib.decompress(packed), 'u1').reshape(height, 1 + channels * width)
    out = numpy.zeros((height, channels * width), 'u1')
    for y in range(height):
        filtered, before = rows[y, 1:].astype(int), out[y - 1].astype(int) if y else numpy.zeros(channels * width, int)
        kind, line = rows[y, 0], numpy.zeros(channels * width, int)
        if kind in (0, 2):
            line = (filtered + (before if kind else 0)) % 256
        else:
            for x in range(channels * width):
                left, up, corner = (line[x - channels], before[x], before[x - channels]) if x >= channels else (
                    0, before[x], 0)
                guess = left + up - corner
                paeth = min((left, up, corner), key=lambda c: abs(guess - c))
                line[x] = (filtered[x] + {1: left, 3: (left + up) // 2, 4: paeth}[kind]) % 256
        out[y] = line
    return out.reshape(height, width, channels)


def nifti(path, array):
    """Writes an array of bytes, indexed [z, y, x], as a NIfTI-1 file."""
    header = bytearray(352)
    struct.pack_into('<i', header, 0, 348)
    struct.pack_into('<8h', header, 40, 3, *array.shape[::-1], 1, 1, 1, 1)
    struct.pack_into('<2h', header, 70, 2, 8)
    struct.pack_into('<8f', header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
    struct.pack_into('<2f', header, 108, 352, 1)
    header[344:348] = b'n+1\0'
    pathlib.Path(path).write_bytes(gzip.compress(bytes(header) + array.tobytes()))


def ball(dtype='u1', size=24):
    z, y, x = numpy.mgrid[:size, :size + 3, :size + 7]
    inside = (x - 9.0)**2 + (y - 12.0)**2 + (1.3 * z - 14.0)**2
    return (100 * numpy.clip(1.4 - inside / 120, 0, 1)).astype(dtype)


def run_tests():
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])

"""The Python package against the program, NumPy and other people's arrays.

  python_test.py PROGRAM PACKAGE_FOLDER [unittest's arguments]
"""
import ast
import doctest
import functools
import gc
import gzip
import http.server
import importlib.util
import json
import os
import pathlib
import shutil
import signal
import ssl
import struct
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock
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


class Pictures(unittest.TestCase):
    def assertSamePicture(self, one, other):
        self.assertEqual(one.shape, other.shape)
        self.assertEqual(int(numpy.abs(one.astype(int) - other.astype(int)).max()), 0)

    def command(self, *options):
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, 'p.png')
            subprocess.run([PROGRAM, 'render', *options, '-o', out, '-q'], check=True)
            return read_png(out)

    def test_equal_those_of_the_command_to_the_byte(self):
        volume = sluice.open(PHANTOM)
        for options, words in [
            (dict(size=(96, 80)), ['--size', '96x80']),
            (dict(size=64, threshold=40, shade=False, azimuth=30, elevation=-20, map='viridis'),
             ['--size', '64', '--threshold', '40', '--no-shade', '--azimuth', '30', '--elevation', '-20', '--map',
              'viridis']),
            (dict(size=64, opacities={10: 0, 60: 0.1, 255: 0.4}, range=(0, 200), projection='perspective', fov=50),
             ['--size', '64', '--opacities', '10:0,60:0.1,255:0.4', '--range', '0,200', '--projection', 'perspective',
              '--fov', '50']),
            (dict(size=64, mode='mip', crop=(0, 0, 0, 64, 32, 48), view='left', zoom=1.5),
             ['--size', '64', '--mode', 'mip', '--crop', '0,0,0,64,32,48', '--view', 'left', '--zoom', '1.5']),
            (dict(size=64, threshold=10, modulate=True), ['--size', '64', '--threshold', '10', '--modulate']),
            (dict(size=64, threshold=10, clip=[(1, 0, 0, 30)], step=0.7, modulate=True, full_gradient=0.2, opacity=0.2),
             ['--size', '64', '--threshold', '10', '--clip', '1,0,0,30', '--step', '0.7', '--modulate',
              '--full-gradient', '0.2', '--opacity', '0.2']),
            (dict(size=64, iso=[100, (180, 0.4, 'ff8800')], light=(60, 10), ambient=0.2),
             ['--size', '64', '--iso', '100,180:0.4:ff8800', '--light', '60,10', '--ambient', '0.2']),
            (dict(size=64, iso='100:0.5', threshold=40), ['--size', '64', '--iso', '100:0.5', '--threshold', '40']),
            (dict(size=64, label={'all': ':0.1', 120: 'red:1'}),
             ['--size', '64', '--label', 'all=:0.1', '--label', '120=red:1'])]:
            with self.subTest(words):
                self.assertSamePicture(volume.render(**options), self.command(PHANTOM, *words))

    def test_of_volumes_over_others_have_warnings_about_their_places(self):
        with tempfile.TemporaryDirectory() as folder:
            def nrrd(name, unit, origin):
                path = os.path.join(folder, name)
                units = f'space units: "{unit}" "{unit}" "{unit}"\n' if unit else ''
                with open(path, 'wb') as file:
                    file.write((f'NRRD0004\ntype: uint8\ndimension: 3\nspace dimension: 3\nsizes: 15 11 8\n'
                                f'space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: ({origin},0,0)\n{units}'
                                'encoding: raw\n\n').encode() + ball(size=8).tobytes())
                return path
            scan, bare, far = nrrd('scan.nrrd', 'um', 0), nrrd('bare.nrrd', '', 2), nrrd('far.nrrd', 'um', 50)
            self.assertRegex(' '.join(sluice.open(scan, over=bare).info['warnings']),
                             'bare.nrrd has no unit of length, and scan.nrrd has the unit micrometer')
            self.assertRegex(' '.join(sluice.open(scan, over=far).info['warnings']), 'far.nrrd: lies beside scan.nrrd')

    def test_of_a_volume_over_another_one_equal_those_of_the_command(self):
        shells = 'synth:shells,dims=64x48x56'
        volume = sluice.open('synth:phantom,dims=64x48x56', over=shells)
        words = ['synth:phantom,dims=64x48x56', '--over', shells, '--size', '64', '--device', 'cpu']
        for options, more in [
            (dict(), []), (dict(look=['over:green,20:200,0.3']), ['--look', 'over:green,20:200,0.3']),
            (dict(combine='blend', threshold=40), ['--combine', 'blend', '--threshold', '40'])]:
            with self.subTest(more):
                renderer = sluice.Renderer(volume, device='cpu')
                self.assertSamePicture(renderer.render(size=64, **options), self.command(*words, *more))
        # They are one medium unless light looks around, whatever a renderer drew before.
        renderer = sluice.Renderer(volume, device='cpu')
        blended = renderer.render(size=64, shade=True)
        self.assertSamePicture(renderer.render(size=64, shade=True, shadows=0.5),
                               self.command(*words, '--shade', '--shadows=0.5'))
        numpy.testing.assert_array_equal(renderer.render(size=64, shade=True), blended)
        self.assertSamePicture(blended, self.command(*words, '--shade', '--combine', 'blend'))
        with self.assertRaisesRegex(sluice.Error, 'combine blend needs mode composite'):
            volume.render(size=64, combine='blend', mode='mip')

    def test_of_labels_over_a_scan_are_blended_from_levels(self):
        with tempfile.TemporaryDirectory() as folder:
            scan, labels = os.path.join(folder, 'scan.zarr'), os.path.join(folder, 'labels.zarr')
            for kind, path, *more in [('phantom', scan), ('parts', labels, '--downsample', 'mode')]:
                subprocess.run([PROGRAM, 'pack', f'synth:{kind},dims=96x96x96', '-o', path, '--levels', '2', '-q', *more],
                               check=True)
            renderer = sluice.Renderer(sluice.open(scan, over=labels), device='cpu')
            # The program's picture has the index that the package made.
            for level in (0, 2):
                with self.subTest(level):
                    self.assertSamePicture(
                        renderer.render(size=64, combine='blend', look=['over:labels,0.4'], level=level),
                        self.command(scan, '--over', labels, '--size', '64', '--device', 'cpu', '--combine', 'blend',
                                     '--look', 'over:labels,0.4', '--level', str(level)))

    def test_over_a_background_are_opaque(self):
        volume = sluice.open(PHANTOM)
        picture = volume.render(size=64, threshold=40, background='#102030')
        self.assertTrue((picture[..., 3] == 255).all())
        self.assertEqual(picture[0, 0].tolist(), [0x10, 0x20, 0x30, 255])
        command = self.command(PHANTOM, '--size', '64', '--threshold', '40', '--background', '102030')
        self.assertSamePicture(picture[..., :command.shape[2]], command)

    def test_of_an_array_equal_those_of_its_file(self):
        array = ball('<u2', 20)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'ball.raw')
            array.tofile(path)
            words = [path, '--dims', ','.join(map(str, array.shape[::-1])), '--type', 'u16', '--spacing', '1,1,1.5',
                     '--size', '64', '--threshold', '30']
            expected = self.command(*words)
        picture = sluice.from_array(array, spacing=(1, 1, 1.5)).render(size=64, threshold=30)
        self.assertSamePicture(picture, expected)

    def test_have_the_depth_of_a_cubes_face(self):
        cube = numpy.full((16, 16, 16), 200, 'u1')
        rgba, depth = sluice.from_array(cube).render(view='plain', size=33, opacities={0: 1, 255: 1}, depth=True,
                                                     fit='volume')
        inside = numpy.isfinite(depth)
        self.assertTrue((inside == (rgba[..., 3] > 0)).all())
        self.assertLess(numpy.ptp(depth[12:21, 12:21]), 0.01)

    def test_of_several_threads_have_their_own_looks(self):
        volume = sluice.from_array(ball())
        renderer = sluice.Renderer(volume, device='cpu')
        thresholds = [10, 25, 40, 55]
        expected = [volume.render(size=48, threshold=t) for t in thresholds]
        wrong = []

        def draw(number):
            for _ in range(8):
                picture = renderer.render(size=48, threshold=thresholds[number])
                if not (picture == expected[number]).all():
                    wrong.append(number)

        threads = [threading.Thread(target=draw, args=(n,)) for n in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_are_saved_as_they_are_drawn(self):
        volume = sluice.from_array(ball())
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / 'p.png'
            volume.save(path, size=40, threshold=30)
            self.assertSamePicture(read_png(path), volume.render(size=40, threshold=30))
            self.assertEqual(os.listdir(folder), ['p.png'])
            with self.assertRaisesRegex(sluice.Error, 'no/such'):
                volume.save('no/such/folder/p.png', size=8)

    def test_are_shown_by_notebooks(self):
        png = sluice.from_array(ball())._repr_png_()
        with tempfile.NamedTemporaryFile(suffix='.png') as file:
            file.write(png)
            file.flush()
            self.assertEqual(read_png(file.name).shape, (512, 512, 4))


class Arrays(unittest.TestCase):
    def picture(self, array):
        return sluice.from_array(array).render(size=40, threshold=20)

    def test_of_every_order_and_sign_are_borrowed(self):
        array = ball()
        expected = self.picture(array)
        wide = numpy.zeros([2 * n for n in array.shape], 'u1')
        wide[::2, ::2, ::2] = array
        read_only = array.copy()
        read_only.flags.writeable = False
        for name, view in [('Fortran', numpy.asfortranarray(array)), ('every second', wide[::2, ::2, ::2]),
                           ('read only', read_only), ('mirrored twice', array[::-1, :, ::-1].copy()[::-1, :, ::-1]),
                           ('transposed', numpy.ascontiguousarray(array.transpose(2, 0, 1)).transpose(1, 2, 0))]:
            with self.subTest(name):
                self.assertTrue((view == array).all())
                self.assertTrue((self.picture(view) == expected).all())

    def test_of_every_type_have_their_values(self):
        for dtype in ['?', 'u1', 'i1', 'u2', 'i2', 'u4', 'i4', 'f4', 'f8']:
            with self.subTest(dtype):
                array = ball(dtype)
                volume = sluice.from_array(array)
                self.assertEqual(volume.shape, array.shape)
                self.assertEqual(volume.value_range, (array.min(), array.max()))
                plane = volume.slice('z', 10)
                self.assertTrue((plane == array[10].astype('f4')).all())
                self.assertTrue((volume.slice('x', 5) == array[:, :, 5].astype('f4')).all())
                self.assertTrue((volume.slice('y', 7) == array[:, 7].astype('f4')).all())

    def test_with_several_steps_are_series(self):
        steps = numpy.stack([ball(), 2 * ball()])
        volume = sluice.from_array(steps)
        self.assertEqual((volume.time_steps, volume.shape), (2, steps.shape))
        self.assertTrue((volume.slice('z', 9, time=1) == steps[1, 9]).all())

    def test_that_are_no_volume_are_refused(self):
        for array, error, words in [
            (numpy.zeros((4, 4)), ValueError, '2 axes'), (numpy.zeros((2, 2, 2, 2, 2)), ValueError, '5 axes'),
            (numpy.zeros((4, 0, 4)), ValueError, 'at least one voxel'),
            (numpy.zeros((4, 4, 4), 'c8'), TypeError, 'complex64'),
            (numpy.zeros((4, 4, 4), 'f2'), TypeError, 'float16'),
            (numpy.zeros((4, 4, 4), 'i8'), TypeError, 'int64'),
            (numpy.zeros((4, 4, 4), '>f4'), TypeError, 'byte order'),
            (numpy.zeros((4, 4, 4), 'U3'), TypeError, '<U3'),
            (numpy.zeros((4, 4, 4), 'c16'), TypeError, r'complex128; give .* numpy.abs\(array\)'),
            (numpy.zeros((4, 4, 4), 'M8[s]'), TypeError, r'datetime64\[s\]; convert them, as with \(array - '),
            (numpy.zeros((4, 4, 4), 'm8[ns]'), TypeError, r'timedelta64\[ns\]; convert'),
            (numpy.zeros((4, 4, 4), 'O'), TypeError, 'found object; convert'),
            (numpy.zeros((4, 4, 4), [('a', 'u1'), ('b', 'f4')]), TypeError, r"give one field, as array\['a'\]")]:
            with self.subTest(words), self.assertRaisesRegex(error, words):
                sluice.from_array(array)
        fields = numpy.zeros((4, 4, 4), [('a', 'u1'), ('b', 'f4')])
        self.assertEqual(sluice.from_array(fields['b']).value_range, (0, 0))
        with self.assertRaisesRegex(sluice.Error, 'spacing'):
            sluice.from_array(ball(), spacing=(1, 0, 1))

    def test_of_the_smallest_numbers_have_a_warning(self):
        for values in (ball('f4') * numpy.float32(1e-42), -ball('f8') * 1e-42):
            self.assertRegex(' '.join(sluice.from_array(values).info['warnings']), 'closer to 0 than 1.2e-38')
        self.assertEqual(sluice.from_array(ball('f4') * numpy.float32(1e-5)).info['warnings'], [])
        self.assertEqual(sluice.from_array(ball('f4') * 0).info['warnings'], [])

    def test_stay_while_the_volume_is_open(self):
        expected = self.picture(ball())
        volume = sluice.from_array(ball())
        gc.collect()
        junk = [numpy.full(100_000, 255, 'u1') for _ in range(20)]
        self.assertTrue((volume.render(size=40, threshold=20) == expected).all())
        del junk

    def test_of_zarr_are_read_box_by_box(self):
        try:
            import zarr
        except ImportError:
            self.skipTest('python3-zarr is not installed')
        array = ball('i2', 40)
        stored = zarr.array(array, chunks=(16, 16, 16))
        volume = sluice.from_array(stored)
        self.assertTrue((volume.render(size=40, threshold=20) == self.picture(array)).all())

    def test_of_dask_are_computed_box_by_box(self):
        try:
            import dask.array
        except ImportError:
            self.skipTest('python3-dask is not installed')
        array = ball('i2', 40)
        computed = []

        def seen(block):
            computed.append(block.shape)
            return block

        lazy = dask.array.from_array(array, chunks=(16, 16, 16)).map_blocks(seen, dtype='i2', meta=array[:0])
        volume = sluice.from_array(lazy)
        self.assertTrue((volume.render(size=40, threshold=20) == self.picture(array)).all())
        self.assertLessEqual(max(computed), (16, 16, 16))

    def test_of_xarray_are_those_inside(self):
        try:
            import xarray
        except ImportError:
            self.skipTest('python3-xarray is not installed')
        array = ball('i2', 40)
        named = xarray.DataArray(array, dims=('z', 'y', 'x'), coords={'x': numpy.arange(array.shape[2]) * 0.5}, name='ball')
        kinds = [named, named.transpose('x', 'y', 'z').transpose('z', 'y', 'x')]
        if importlib.util.find_spec('dask') is not None:
            kinds.append(named.chunk(16))
        for each in kinds:
            volume = sluice.from_array(each)
            self.assertTrue((volume.render(size=40, threshold=20) == self.picture(array)).all())

    def test_that_a_function_gives_may_fail(self):
        calls = []

        def fill(time, lo, hi):
            calls.append((lo, hi))
            if len(calls) > 1:
                raise KeyError('gone')
            return numpy.zeros(tuple(hi[a] - lo[a] for a in (2, 1, 0)), 'u1')

        with self.assertRaisesRegex(KeyError, 'gone'):
            sluice.from_function(fill, (200, 200, 200), 'u1', threads=1).render(size=16, threshold=0)
        with self.assertRaisesRegex(ValueError, 'contiguous array'):
            sluice.from_function(lambda time, lo, hi: numpy.zeros((1, 1, 1), 'u1'), (30, 30, 30), 'u1')

    def test_have_numpys_histogram(self):
        array = ball()
        counts, edges = sluice.from_array(array).histogram(16)
        self.assertEqual(int(counts.sum()), array.size)
        self.assertEqual((edges[0], edges[-1]), (array.min(), array.max()))


class Plans(unittest.TestCase):
    def command(self, *words):
        text = subprocess.run([PROGRAM, 'plan', *words, '--json', '-q'], check=True, stdout=subprocess.PIPE).stdout
        return json.loads(text)

    def test_have_the_keys_and_numbers_of_the_command(self):
        for path, options, words in [
            (PHANTOM, dict(size=(96, 80), threshold=40), ['--size', '96x80', '--threshold', '40']),
            (PHANTOM, dict(size=64, threshold=10, crop=(0, 0, 0, 64, 32, 48)),
             ['--size', '64', '--threshold', '10', '--crop', '0,0,0,64,32,48']),
            ('synth:shells,dims=100x90x80', dict(size=64, mode='mip'), ['--size', '64', '--mode', 'mip'])]:
            with self.subTest(words):
                plan = sluice.open(path).plan(**options)
                command = self.command(path, *words)
                about_the_picture = {'command', 'options', 'volume', 'transfer'}
                self.assertEqual(set(plan), set(command) - about_the_picture)
                for key in ('blocks', 'algorithms', 'clusters'):
                    self.assertEqual(plan[key], command[key], key)
                self.assertEqual(plan['read']['blocks'], command['read']['blocks'])
                if 'mip' not in words:  # the package opens volumes for lit pictures, whose blocks have wider borders
                    self.assertEqual(plan['read'], command['read'])
                self.assertEqual(set(plan['memory']), set(command['memory']))
                self.assertEqual(plan['memory']['budget_bytes'], command['memory']['budget_bytes'])
                self.assertTrue(plan['memory']['fits'])
                self.assertGreaterEqual(plan['seconds'], plan['plan_seconds'])

    def test_are_of_a_picture_that_then_reads_as_many_blocks(self):
        volume = sluice.open('synth:shells,dims=100x90x80')
        renderer = sluice.Renderer(volume, device='cpu')
        plan = renderer.plan(size=64, threshold=120)
        self.assertEqual(renderer.report()['volume_buffer']['loads'], 0)
        renderer.render(size=64, threshold=120)
        report = renderer.report()
        self.assertEqual(report['blocks'], plan['blocks'])
        self.assertEqual(report['volume_buffer']['loads'], plan['read']['blocks'])
        self.assertEqual(report['pages_loaded'], plan['algorithms']['merged']['pages'])

    def test_are_of_levels_that_an_opening_made(self):
        with tempfile.TemporaryDirectory() as folder:
            name = os.path.join(folder, 'ball_96x96x96_uint8.raw')
            z, y, x = numpy.mgrid[:96, :96, :96] - 47.5
            voxels = (200 * numpy.clip(2 - (x * x + y * y + z * z) / 900, 0, 1)).astype('u1')
            voxels[10, 10, 20:60] = 255
            pathlib.Path(name).write_bytes(voxels.tobytes())
            volume = sluice.open(name, index_dir=folder, levels='always')

            def coarse_share(**options):
                return volume.plan(threshold=220, fit='volume', **options)['cut']['coarse_share']
            self.assertEqual(coarse_share(size=32), 1)
            self.assertLess(coarse_share(size=32, keep_thin=True), 1)
            self.assertEqual(coarse_share(size=128, pixel_error=0.5), 0)
            self.assertEqual(coarse_share(size=128, pixel_error=0.5, max_bytes=1 << 16), 1)
            with self.assertRaisesRegex(ValueError, 'levels: expected'):
                sluice.open(name, levels='some')

    def test_name_the_levels_of_a_store(self):
        with tempfile.TemporaryDirectory() as folder:
            store = os.path.join(folder, 's.zarr')
            subprocess.run([PROGRAM, 'pack', 'synth:shells,dims=128x128x128', '-o', store, '--levels', '2', '-q'],
                           check=True)
            options = dict(size=32, pixel_error=4)
            plan = sluice.open(store).plan(**options)
            command = self.command(store, '--size', '32', '--pixel-error', '4')
            self.assertEqual(plan['cut']['levels'], command['cut']['levels'])
            self.assertGreater(plan['cut']['coarse_share'], 0)

    def test_of_two_volumes_are_those_of_the_command(self):
        scan, labels = 'synth:phantom,dims=96x96x96', 'synth:parts,dims=96x96x96'
        look = ['over:labels,0.3']
        for combine in (None, 'add', 'blend'):
            with self.subTest(combine):
                options = dict(size=64, threshold=40, look=look, **(dict(combine=combine) if combine else {}))
                plan = sluice.open(scan, over=labels).plan(**options)
                command = self.command(scan, '--over', labels, '--size', '64', '--threshold', '40', '--look', look[0],
                                       *(['--combine', combine] if combine else []))
                self.assertEqual([channel['channel'] for channel in plan['channels']], [0, 'over'])
                for own, other in zip([plan, *plan['channels']], [command, *command['channels']]):
                    self.assertEqual(set(own), set(other) - {'command', 'options', 'volume', 'transfer'})
                    # The package opens volumes for lit pictures, whose blocks have wider borders.
                    self.assertEqual(own['blocks'], other['blocks'])
                    self.assertEqual(own['read']['blocks'], other['read']['blocks'])
                parts = [plan, *plan['channels']]
                for of in [[part[key] for part in parts] for key in ('blocks', 'read', 'most_read')] + [
                        [part['algorithms'][way] for part in parts] for way in plan['algorithms']]:
                    for name, value in of[0].items():
                        self.assertEqual(value, of[1][name] + of[2][name], name)
                renderer = sluice.Renderer(sluice.open(scan, over=labels), device='cpu')
                plan = renderer.plan(**options)
                renderer.render(**options)
                report = renderer.report()
                self.assertEqual(report['volume_buffer']['loads'], plan['read']['blocks'])
                self.assertEqual(report['pages_loaded'], plan['algorithms']['merged']['pages'])

    def test_that_are_wrong_say_so(self):
        with self.assertRaisesRegex(ValueError, 'zoom'):
            sluice.open(PHANTOM).plan(zoom=-1)


class Requests(unittest.TestCase):
    def test_that_are_wrong_name_the_keyword(self):
        volume = sluice.from_array(ball())
        for options, error, words in [
            (dict(colour='red'), TypeError, "unexpected keyword 'colour'"),
            (dict(zoom='much'), TypeError, 'zoom'), (dict(zoom=0), ValueError, 'zoom'),
            (dict(zoom=float('nan')), ValueError, 'zoom'), (dict(size=(0, 4)), ValueError, 'size'),
            (dict(size=1 << 20), ValueError, 'size'), (dict(size='big'), TypeError, 'size'),
            (dict(view='inside'), ValueError, "one of 'plain'"), (dict(crop=(0, 0, 0, 4)), ValueError, 'crop'),
            (dict(crop=(0, 0, 0, 400, 4, 4)), ValueError, 'crop'), (dict(time=3), ValueError, 'time'),
            (dict(time=-1), ValueError, 'time'), (dict(map='pinkish'), sluice.Error, 'pinkish'),
            (dict(background='red'), ValueError, 'background'), (dict(eye=(0, 0, 0)), TypeError, 'eye requires target'),
            (dict(threshold=4, labels=True), TypeError, 'threshold and labels'),
            (dict(level=1, pixel_error=2), TypeError, 'level and pixel_error'),
            (dict(opacities=[(5, 0.1), (1, 0.2)]), ValueError, 'opacities'),
            (dict(opacities=[(5, 2)]), ValueError, 'opacities'), (dict(level=-1), ValueError, 'level'),
            (dict(level=5), sluice.Error, 'level'), (dict(transfer='no/such.json'), sluice.Error, 'no/such.json'),
            (dict(full_gradient=0.05), TypeError, 'full_gradient requires modulate'),
            (dict(full_gradient=0.05, modulate=False), TypeError, 'full_gradient requires modulate'),
            (dict(mode='mip', iso=40), TypeError, "^iso needs mode composite, since other modes show one value"),
            (dict(mode='mip', shadows=True), TypeError, '^shadows needs mode composite'),
            (dict(mode='minip', jitter=0.5), TypeError, '^jitter needs mode composite'),
            (dict(mode='average', depth_cueing=1), TypeError, '^depth_cueing needs mode composite'),
            (dict(shade=False, shadows=0.5, occlusion_light=True), TypeError,
             "^shadows lights the picture; leave out shade=False"),
            (dict(modulate='yes'), TypeError, 'modulate: expected True or False'),
            (dict(max_bytes='20 K B'), ValueError, '^max_bytes: expected bytes'),
            (dict(pixel_error=0), ValueError, 'pixel_error'), (dict(depth='yes'), TypeError, 'depth')]:
            with self.subTest(options), self.assertRaisesRegex(error, words):
                volume.render(**options)
        with self.assertRaisesRegex(ValueError, 'device'):
            sluice.Renderer(volume, device='abacus')
        with self.assertRaisesRegex(ValueError, 'memory'):
            sluice.Renderer(volume, memory='lots')
        for call, error, words in [
                (lambda: sluice.Renderer(volume, memory=-1), ValueError, "^memory: expected bytes .*, found -1$"),
                (lambda: sluice.Renderer(volume, memory=float('nan')), ValueError, '^memory: .*, found nan$'),
                (lambda: sluice.Renderer(volume, memory=0), ValueError, '^memory: .*, found 0$'),
                (lambda: sluice.Renderer(volume, memory=1.5), ValueError, '^memory: .*, found 1.5$'),
                (lambda: sluice.open(PHANTOM, cache=-4, cache_dir='c'), ValueError, '^cache: .*, found -4$'),
                (lambda: sluice.Renderer(volume, threads='x'), TypeError, "^threads: .* whole number, found 'x'$"),
                (lambda: sluice.Renderer(volume, device=4), TypeError, '^device: expected a text, found 4$'),
                (lambda: volume.slice('z', 'a'), TypeError, "^at: .* whole number, found 'a'$"),
                (lambda: volume.slice('z', 1, most=1 << 40), ValueError, '^most: .* 32 bits'),
                (lambda: volume.probe('a', 0.5), TypeError, "^right: expected a number, found 'a'$"),
                (lambda: volume.probe(0.5, float('nan')), TypeError, '^down: expected a number, found nan$'),
                (lambda: volume.histogram(2.5), TypeError, '^bins: .* whole number, found 2.5$'),
                (lambda: sluice.from_function(len, ('a', 2, 2), 'f4'), TypeError, '^shape: .* whole number'),
                (lambda: sluice.from_function(4, (4, 4, 4), 'f4'), TypeError, '^fill: expected a function'),
                (lambda: sluice.simulate('t', page_bytes='x'), TypeError, '^page_bytes: '),
                (lambda: sluice.simulate('t', policies='lru'), TypeError, '^policies: expected a list of names'),
                (lambda: sluice.simulate('t', sizes=[0.5]), TypeError, '^sizes: .* whole number'),
                (lambda: sluice.simulate('t', sizes=[-1]), ValueError, '^sizes: .* from 1, found -1$'),
                (lambda: sluice.open(PHANTOM, channel=[]), ValueError, '^channel: expected one or more')]:
            with self.subTest(words), self.assertRaisesRegex(error, words):
                call()
        with self.assertRaisesRegex(sluice.Error, 'no/such/file.nrrd'):
            sluice.open('no/such/file.nrrd')
        for options, error, words in [
                (dict(algorithm='V'), sluice.Error, '^algorithm "V": expected one of conventional, '),
                (dict(pages=3), sluice.Error, '^pages 3: '), (dict(pages='a'), TypeError, '^pages: .*whole number'),
                (dict(policy=4), TypeError, '^policy: expected text, found 4'),
                (dict(seed=-1), TypeError, '^seed: .* from 0, found -1'), (dict(wheels=4), TypeError, 'wheels')]:
            with self.subTest(options), self.assertRaisesRegex(error, words):
                sluice.Renderer(volume, **options)
        for options, error, words in [
                (dict(block=17), sluice.Error, '^block 17: '), (dict(block='x'), TypeError, '^block: .*whole number'),
                (dict(page=(1, 2)), TypeError, '^page: expected three whole numbers'),
                (dict(dims='x'), TypeError, '^dims: '),
                (dict(dims=(4, 4, 4, 1)), ValueError, r'^dims: expected 3 whole numbers \(X,Y,Z\), found '),
                (dict(dims=(4.0, 4, 4)), TypeError, r'^dims: expected 3 whole numbers \(X,Y,Z\), found '),
                (dict(skip=2**60 + 1), ValueError, f'^skip: expected a whole number .* to {2**60}, found '),
                (dict(spacing=2), TypeError, '^spacing: expected 3 numbers'),
                (dict(dims=(4, 0, 1)), ValueError, '^dims: expected a whole number from 1 .*, found 0$'),
                (dict(type='u9'), ValueError, "^type: expected one of 'u8', .*, found 'u9'$"),
                (dict(endian='middle'), ValueError, "^endian: expected one of 'little', 'big', found 'middle'$"),
                (dict(channel=-1), ValueError, '^channel: .*, found -1$'), (dict(channel=1.5), TypeError, '^channel: '),
                (dict(over=4), TypeError, '^over: expected a name'),
                (dict(time_steps=2), TypeError, '^time_steps requires dims$'),
                (dict(grid=''), ValueError, "^grid: expected a name that is not empty, found ''$"),
                (dict(channel=''), ValueError, "^channel: expected a name that is not empty, found ''$"),
                (dict(channel=['']), ValueError, "^channel: expected a name that is not empty, found ''$"),
                (dict(over=''), ValueError, '^over: expected a name'),
                (dict(wheels=4), TypeError, "^unexpected keyword 'wheels'; there are: dims, .*, over, time, .*, threads"),
                (dict(grid=4), TypeError, '^grid: '), (dict(opens_soon='x'), TypeError, '^opens_soon: ')]:
            with self.subTest(options), self.assertRaisesRegex(error, words):
                sluice.open('synth:cube,dims=20x16x12', **options)

    def test_that_fail_say_what_has_to_change_in_words_of_python(self):
        volume = sluice.from_array(ball())
        for call, kind, words in [
            (lambda: sluice.open('no/such/file.nrrd'), 'input', 'no/such/file.nrrd'),
            (lambda: sluice.Renderer(volume, memory=10), 'memory', '^memory .* give memory'),
            (lambda: volume.render(map='pinkish'), 'request', 'map'),
            (lambda: volume.render(iso='5:0.4:pinkish'), 'request', '^iso 5:0.4:pinkish: there is no colour'),
            (lambda: volume.render(level=5), 'request', 'level 5'),
            (lambda: volume.save('/dev/full/picture.png'), 'input', '/dev/full')]:
            with self.subTest(words), self.assertRaisesRegex(sluice.Error, words) as caught:
                call()
            self.assertEqual(caught.exception.kind, kind)
            self.assertNotIn('--', str(caught.exception))

    def test_of_buckets_find_a_key_where_amazons_tools_do(self):
        before = dict(os.environ)
        with tempfile.TemporaryDirectory() as folder:
            home = pathlib.Path(folder)
            (home / '.aws').mkdir()
            (home / '.aws/credentials').write_text('[lab]\naws_access_key_id = A\naws_secret_access_key = B=%C\n')
            (home / '.aws/config').write_text('[profile lab]\nregion = us-west-2\n[default]\nregion = sa-east-1\n')
            try:
                for name in [name for name in os.environ if name.startswith('AWS_')]:
                    del os.environ[name]
                os.environ.update(HOME=folder)
                def key():
                    return sluice._sluice.bucket_access(os.environ.get)
                self.assertEqual(key()['region'], 'sa-east-1')
                self.assertEqual(key()['access_key'], '')
                os.environ['AWS_PROFILE'] = 'lab'
                self.assertEqual(key(), dict(access_key='A', secret_key='B=%C', session_token='',
                                                     region='us-west-2', endpoint=''))
                os.environ.update(AWS_ACCESS_KEY_ID='D', AWS_SECRET_ACCESS_KEY='E', AWS_REGION='eu-west-1')
                self.assertEqual(key(), dict(access_key='D', secret_key='E', session_token='',
                                                     region='eu-west-1', endpoint=''))
                os.environ['AWS_PROFILE'] = 'lap'
                with self.assertRaisesRegex(sluice.Error, 'no profile lap'):
                    sluice.open('s3://bucket/key')
            finally:
                os.environ.clear()
                os.environ.update(before)

    def test_take_none_as_the_default(self):
        volume = sluice.from_array(ball())
        same = {keyword: None for keyword in sluice._sluice.keywords()}
        self.assertTrue((volume.render(**{**same, 'size': 32}) == volume.render(size=32)).all())

    def test_modulate_with_the_ramp_of_the_program(self):
        volume = sluice.from_array(ball())
        plain, modulated, given, other = (
            volume.render(size=32, threshold=10, **options)
            for options in ({}, dict(modulate=True), dict(modulate=True, full_gradient=0.1),
                            dict(modulate=True, full_gradient=0.9)))
        self.assertTrue((modulated == given).all())
        self.assertFalse((modulated == plain).all())
        self.assertFalse((modulated == other).all())
        self.assertTrue((volume.render(size=32, threshold=10, modulate=False) == plain).all())

    def test_take_bytes_as_the_program_does(self):
        volume = sluice.from_array(ball())
        expected = volume.render(size=32, max_bytes=20 << 10)
        self.assertTrue((volume.render(size=32, max_bytes='20K') == expected).all())

    def test_have_every_keyword_in_the_docstring(self):
        words = set(sluice.Renderer.render.__doc__.replace(',', ' ').replace('.', ' ').split())
        self.assertLessEqual(set(sluice._sluice.keywords()), words)
        for keyword, _ in sluice._sluice.volume_keyword_types():
            self.assertIn(f'`{keyword}`', sluice.open.__doc__)

    def test_have_every_keyword_in_the_stubs(self):
        stubs = ast.parse((pathlib.Path(PACKAGE) / 'sluice/__init__.pyi').read_text())
        for name, keywords in [('PictureOptions', set(sluice._sluice.keywords()) - {'depth'}),
                               ('VolumeOptions', {keyword for keyword, _ in sluice._sluice.volume_keyword_types()})]:
            options = next(node for node in stubs.body if getattr(node, 'name', '') == name)
            self.assertEqual({field.target.id for field in options.body}, keywords)

    def test_tell_progress(self):
        told = []
        volume = sluice.open(PHANTOM, progress=lambda *step: told.append(step))
        self.assertEqual(told[-1][0], 'indexing')
        self.assertEqual(told[-1][1], told[-1][2])
        stages = []
        volume.render(size=32, progress=lambda stage, done, total: stages.append(stage))
        self.assertEqual(set(stages), {'drawing'})

        def complain(*step):
            raise LookupError('enough')

        with self.assertRaisesRegex(LookupError, 'enough'):
            volume.render(size=32, progress=complain)
        self.assertEqual(volume.render(size=32).shape, (32, 32, 4))
        with self.assertRaisesRegex(TypeError, '^progress: expected a function, found 3'):
            volume.render(size=32, progress=3)

    def test_are_ended_by_a_signal_within_a_second(self):
        class Enough(Exception):
            pass

        def handler(*_):
            raise Enough

        volume = sluice.open('synth:phantom,dims=256x256x256')
        before = signal.signal(signal.SIGALRM, handler)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.3)
            began = time.monotonic()
            with self.assertRaises(Enough):
                while True:
                    volume.render(size=2000, step=0.05)
            self.assertLess(time.monotonic() - began, 60)  # not never; how fast it is, is no test
        finally:
            signal.signal(signal.SIGALRM, before)
        self.assertEqual(volume.render(size=32).shape, (32, 32, 4))

    def test_in_a_forked_process_say_what_to_do(self):
        volume = sluice.from_array(ball())
        renderer = sluice.Renderer(volume)
        renderer.render(size=16)
        child = os.fork()
        if child == 0:
            status = 1
            try:
                renderer.render(size=16)
            except sluice.Error as error:
                status = 0 if 'fork' in str(error) else 2
            del renderer
            gc.collect()
            os._exit(status)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
        self.assertEqual(renderer.render(size=16).shape, (16, 16, 4))

    def test_give_their_memory_back(self):
        def resident():
            gc.collect()
            return int(pathlib.Path('/proc/self/statm').read_text().split()[1]) * os.sysconf('SC_PAGE_SIZE')

        volume = sluice.from_array(ball())

        def once():
            volume.render(size=128, threshold=20)
            with self.assertRaises(ValueError):
                volume.render(zoom=-1)
            with self.assertRaises(sluice.Error):
                volume.render(size=8, map='pinkish')
            sluice.from_array(ball()).render(size=16)

        for _ in range(20):
            once()
        before = resident()
        for _ in range(200):
            once()
        self.assertLess(resident() - before, 16 << 20)

    def test_that_are_no_volumes_or_places_are_refused_by_their_keywords(self):
        a = numpy.zeros((4, 4, 4), 'u1')
        for keyword, call in [('spacing', lambda: sluice.from_array(a, spacing=(1, 1))),
                              ('spacing', lambda: sluice.from_array(a, spacing=2)),
                              ('origin', lambda: sluice.from_array(a, origin='abc')),
                              ('unit', lambda: sluice.from_array(a, unit=3)),
                              ('path', lambda: sluice.open(3)),
                              ('volume', lambda: sluice.Renderer(a))]:
            with self.subTest(keyword), self.assertRaisesRegex((TypeError, ValueError), f'^{keyword}: expected'):
                call()

    def test_have_names_of_any_bytes_but_zero(self):
        volume = sluice.from_array(ball())
        with tempfile.TemporaryDirectory() as folder:
            for keyword, call in [('path', lambda name: volume.save(name)), ('path', sluice.open),
                                  ('path', lambda name: sluice.open([name])), ('trace', sluice.simulate),
                                  ('path', sluice.Renderer(volume).record_to),
                                  ('transfer', lambda name: volume.render(size=8, transfer=name)),
                                  ('over', lambda name: sluice.open(PHANTOM, over=name)),
                                  ('index_dir', lambda name: sluice.open(PHANTOM, index_dir=name))]:
                with self.subTest(keyword), self.assertRaisesRegex(ValueError, f'^{keyword}: expected a name without'):
                    call(f'{folder}/a\0b.png')
            self.assertEqual(os.listdir(folder), [])
            name = f'{folder}/' + os.fsdecode(b'\xff.png')
            volume.save(name, size=8)
            self.assertEqual(os.listdir(folder.encode()), [b'\xff.png'])
        with self.assertRaisesRegex(ValueError, '^path: expected a name'):
            sluice.open('')

    def test_of_masked_voxels_are_refused(self):
        a = numpy.arange(64, dtype='u1').reshape(4, 4, 4)
        with self.assertRaisesRegex(ValueError, r'array: has masked voxels.*array\.filled'):
            sluice.from_array(numpy.ma.masked_less(a, 9))
        self.assertEqual(sluice.from_array(numpy.ma.masked_less(a, 0)).value_range, (0, 63))

    def test_of_a_wrong_place_for_indices_are_refused(self):
        wrong = {'SLUICE_INDEX': ('of', 'expected off or beside'),
                 'SLUICE_INDEX_DIR': ('here', 'expected the absolute path of a folder')}
        for variable, (value, said) in wrong.items():
            with self.subTest(variable), unittest.mock.patch.dict(os.environ, {'SLUICE_INDEX': ''}):
                os.environ[variable] = value
                with self.assertRaisesRegex(ValueError, f"{variable}: {said}.*'{value}'"):
                    sluice.open('synth:shells,dims=8x8x8')
                sluice.open('synth:shells,dims=8x8x8', index_dir='')


class Certificates(unittest.TestCase):
    """A server of https:// whose authority the system does not know."""
    VARIABLES = ('CURL_CA_BUNDLE', 'SSL_CERT_FILE', 'SSL_CERT_DIR')

    def setUp(self):
        if shutil.which('openssl') is None:
            self.skipTest('openssl is not installed')
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        subprocess.run('openssl req -x509 -newkey rsa:2048 -nodes -keyout key.pem -out cert.pem -days 2 -subj /CN=localhost'
                       ' -addext subjectAltName=DNS:localhost && mkdir trusted && cp cert.pem trusted &&'
                       ' openssl rehash trusted', shell=True, cwd=folder.name, check=True, capture_output=True)
        subprocess.run([PROGRAM, 'pack', 'synth:shells,dims=20x18x16', '-q', '-o', 'v.zarr'], cwd=folder.name, check=True)
        before = {name: os.environ.pop(name) for name in self.VARIABLES if name in os.environ}
        self.addCleanup(os.environ.update, before)
        handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=folder.name)
        handler.func.log_message = lambda *_: None
        server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), handler)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(self.folder / 'cert.pem', self.folder / 'key.pem')
        server.socket = context.wrap_socket(server.socket, server_side=True)
        server.handle_error = lambda *_: None  # a client that refuses the certificate
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        self.address = f'https://localhost:{server.server_address[1]}/v.zarr'
        try:
            sluice.open(self.address)
        except sluice.Error as error:
            if 'sluice_web.so' in str(error):
                self.skipTest('sluice_web.so is not built')

    def open_with(self, **variables):
        os.environ.update({name: str(self.folder / value) for name, value in variables.items()})
        try:
            return sluice.open(self.address)
        finally:
            for name in variables:
                del os.environ[name]

    def test_are_those_that_the_variables_of_curl_name(self):
        for trusted in [dict(CURL_CA_BUNDLE='cert.pem'), dict(SSL_CERT_FILE='cert.pem'), dict(SSL_CERT_DIR='trusted'),
                        dict(CURL_CA_BUNDLE='cert.pem', SSL_CERT_FILE='missing')]:
            with self.subTest(trusted):
                self.assertEqual(self.open_with(**trusted).dims, (20, 18, 16))

    def test_that_nobody_vouches_for_are_refused(self):
        for variables in [{}, dict(CURL_CA_BUNDLE='missing.pem')]:
            with self.subTest(variables), self.assertRaisesRegex(sluice.Error, 'certificate'):
                self.open_with(**variables)


class Levels(unittest.TestCase):
    def test_are_reported_as_the_command_does(self):
        renderer = sluice.Renderer(sluice.open(PHANTOM), device='cpu', memory='128M')
        renderer.render(size=32, threshold=40)
        report = renderer.report()
        self.assertEqual(report['volume_buffer']['requests'],
                         report['volume_buffer']['hits'] + report['volume_buffer']['misses'])
        self.assertLessEqual(report['volume_buffer']['peak_bytes'], 128 << 20)
        self.assertIn('--threshold 40', renderer.look)
        self.assertTrue(renderer.device)

    def test_of_a_recorded_trace_are_simulated_as_the_command_does(self):
        with tempfile.TemporaryDirectory() as folder:
            trace = os.path.join(folder, 'turn.trace')
            renderer = sluice.Renderer(sluice.open(PHANTOM), device='cpu')
            renderer.record_to(trace)
            for angle in (0, 60):
                renderer.render(size=32, threshold=40, azimuth=angle)
            renderer.record_to(None)
            words = [PROGRAM, 'simulate', trace, '--sizes', '16,256', '--policies', 'lru,belady', '--json']
            import json
            rows = json.loads(subprocess.run(words, check=True, capture_output=True).stdout)['rows']
            table = sluice.simulate(trace, sizes=[16, 256], policies=['lru', 'belady'])
            for column in ('policy', 'pages', 'requests', 'hits', 'misses', 'bytes_moved'):
                self.assertEqual(table[column].tolist(), [row[column] for row in rows])
            with self.assertRaisesRegex(ValueError, "^policies: expected some of lru, .*, found 'best'$"):
                sluice.simulate(trace, policies=['best'])


class Documents(unittest.TestCase):
    """The examples of docs/python.md, run one after another as they stand."""

    def test_have_examples_that_run(self):
        page = (pathlib.Path(__file__).parents[2] / 'docs/python.md').read_text()
        examples, lines = [], []
        for line in page.splitlines() + ['end']:
            if line.startswith('    '):
                lines.append(line[4:])
            elif line and lines:
                examples.append('\n'.join(lines))
                lines = []
        programs = [each for each in examples if 'export ' not in each]
        self.assertGreaterEqual(len(programs), 7)
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                self.run_in_order(programs)
                self.assertEqual(len(list(pathlib.Path().glob('turn_*.png'))), 36)
                self.assertTrue(pathlib.Path('bonsai.exr').stat().st_size > 1000)
            finally:
                os.chdir(before)

    def run_in_order(self, programs):
        nifti('bonsai.nii.gz', ball(size=64))
        pathlib.Path('large.raw').write_bytes(bytes(64**3))
        names = {}
        for program in programs:
            needed = [word for word in ('matplotlib', 'tqdm', 'pandas') if f'import {word}' in program
                      or f'from {word}' in program]
            missing = [word for word in needed if importlib.util.find_spec(word) is None]
            if missing:
                print(f'not run, since there is no {missing[0]}: {program.splitlines()[0]}')
                continue
            program = program.replace('2048', '64').replace('256, 128, 256', '64, 32, 64')
            if 'matplotlib' in needed:
                program = "import matplotlib\nmatplotlib.use('agg')\n" + program
            exec(compile(program, 'docs/python.md', 'exec'), names)  # pylint: disable=exec-used
            if 'figure' in program:
                picture = read_png('figure.png')
                self.assertGreater(picture.shape[1], 500)
                self.assertGreater(len(numpy.unique(picture.reshape(-1, picture.shape[2]), axis=0)), 100)


class Widgets(unittest.TestCase):
    def setUp(self):
        if importlib.util.find_spec('ipywidgets') is None:
            sys.modules['ipywidgets'] = stand_in_widgets()
            self.addCleanup(sys.modules.pop, 'ipywidgets')

    def test_draw_anew_when_a_slider_moves(self):
        volume = sluice.from_array(ball(size=32))
        box = volume.widget(size=48, threshold=100, elevation=15)
        image, azimuth, elevation, threshold = box.children
        first = bytes(image.value)
        self.assertEqual(first, sluice._png(volume.render(
            size=48, threshold=100, elevation=15, fit='volume', background='000000')))
        azimuth.value = 45
        self.assertEqual(bytes(image.value), sluice._png(volume.render(
            size=48, threshold=100, azimuth=45, elevation=15, fit='volume', background='000000')))
        threshold.value = threshold.max
        self.assertNotEqual(bytes(image.value), first)
        self.assertEqual(elevation.value, 15)
        clear = volume.widget(size=48, threshold=100, background=None).children[0]
        self.assertEqual(bytes(clear.value), sluice._png(volume.render(size=48, threshold=100, fit='volume')))

    def test_have_no_slider_for_a_look_without_threshold(self):
        self.assertEqual(len(sluice.from_array(ball()).widget(size=16).children), 3)


def stand_in_widgets():
    """The part of ipywidgets that the widget uses, for machines without it."""
    class Widget:
        def __init__(self, **traits):
            self.observers = []
            self.__dict__.update(traits)

        def observe(self, call, _):
            self.observers.append(call)

        def __setattr__(self, name, value):
            self.__dict__[name] = value
            for call in self.observers if name == 'value' else []:
                call(value)

    module = types.ModuleType('ipywidgets')
    module.FloatSlider = module.Image = Widget
    module.VBox = lambda children: Widget(children=tuple(children))
    return module


class Docstrings(unittest.TestCase):
    def test_say_what_happens(self):
        options = doctest.ELLIPSIS
        failed, tried = doctest.testmod(sluice, extraglobs={'sluice': sluice}, optionflags=options)
        self.assertEqual(failed, 0)
        self.assertGreater(tried, 20)


if __name__ == '__main__':
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])

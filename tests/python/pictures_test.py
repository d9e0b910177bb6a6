"""Pictures of the package are those of the program."""
import os
import pathlib
import subprocess
import tempfile
import threading
import unittest

import numpy

from package import PHANTOM, PROGRAM, ball, read_png, run_tests, sluice


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
            (dict(size=numpy.int64(64)), ['--size', '64']),
            (dict(size=64, mode='mip', crop=(0, 0, 0, 64, 32, 48), view='left', zoom=1.5),
             ['--size', '64', '--mode', 'mip', '--crop', '0,0,0,64,32,48', '--view', 'left', '--zoom', '1.5']),
            (dict(size=64, threshold=10, modulate=True), ['--size', '64', '--threshold', '10', '--modulate']),
            (dict(size=64, threshold=10, clip=[(1, 0, 0, 30)], step=0.7, modulate=True, full_gradient=0.2, opacity=0.2),
             ['--size', '64', '--threshold', '10', '--clip', '1,0,0,30', '--step', '0.7', '--modulate',
              '--full-gradient', '0.2', '--opacity', '0.2']),
            (dict(size=64, iso=[100, (180, 0.4, 'ff8800')], light=(60, 10), ambient=0.2),
             ['--size', '64', '--iso', '100,180:0.4:ff8800', '--light', '60,10', '--ambient', '0.2']),
            (dict(size=64, iso='100:0.5', threshold=40), ['--size', '64', '--iso', '100:0.5', '--threshold', '40']),
            (dict(size=64, iso={100: 0.5, 180: (0.4, 'ff8800')}), ['--size', '64', '--iso', '100:0.5,180:0.4:ff8800']),
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


if __name__ == '__main__':
    run_tests()

"""Plans, reports and traces of the package are those of the program."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy

from package import PHANTOM, PROGRAM, run_tests, sluice

# The package has warnings of Python for those of the command.
OF_THE_COMMAND = {'command', 'options', 'volume', 'transfer', 'warnings'}


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
                self.assertEqual(set(plan), set(command) - OF_THE_COMMAND)
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
                    self.assertEqual(set(own), set(other) - OF_THE_COMMAND)
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


class Reports(unittest.TestCase):
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
            rows = json.loads(subprocess.run(words, check=True, capture_output=True).stdout)['rows']
            table = sluice.simulate(trace, sizes=[16, 256], policies=['lru', 'belady'])
            for column in ('policy', 'pages', 'requests', 'hits', 'misses', 'bytes_moved'):
                self.assertEqual(table[column].tolist(), [row[column] for row in rows])
            with self.assertRaisesRegex(ValueError, "^policies: expected some of lru, .*, found 'best'$"):
                sluice.simulate(trace, policies=['best'])


if __name__ == '__main__':
    run_tests()

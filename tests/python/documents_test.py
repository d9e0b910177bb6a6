"""The examples of docs/python.md and of the docstrings run as they stand."""
import doctest
import importlib.util
import os
import pathlib
import tempfile
import unittest

import numpy

from package import ball, nifti, read_png, run_tests, sluice


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


class Docstrings(unittest.TestCase):
    def test_say_what_happens(self):
        options = doctest.ELLIPSIS
        failed, tried = doctest.testmod(sluice, extraglobs={'sluice': sluice}, optionflags=options)
        self.assertEqual(failed, 0)
        self.assertGreater(tried, 20)


if __name__ == '__main__':
    run_tests()

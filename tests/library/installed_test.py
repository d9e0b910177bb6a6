"""What `cmake --install` leaves behind, in a prefix of its own.

  installed_test.py BUILD SOURCE CMAKE CXX [unittest's arguments]
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD, SOURCE, CMAKE, CXX = sys.argv[1:5]


def run(*words, **more):
    """The standard output of a command that must succeed."""
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          **more)
    if done.returncode != 0:
        raise AssertionError(f'{words}: status {done.returncode}\n{done.stdout}')
    return done.stdout


def elf_files(folder):
    return [path for path in sorted(folder.rglob('*')) if path.is_file() and path.read_bytes()[:4] == b'\x7fELF']


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.prefix = pathlib.Path(cls.folder.name) / 'prefix'
        run(CMAKE, '--install', BUILD, '--prefix', cls.prefix)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def environment(self, **more):
        return {**os.environ, 'XDG_CACHE_HOME': self.folder.name + '/cache', **more}

    def test_has_every_part(self):
        for name in ['bin/sluice', 'lib/libsluice.a', 'lib/libsluice.so', 'lib/libsluice.so.0.1', 'lib/cmake/sluice/sluice-config.cmake', 'lib/pkgconfig/sluice.pc',
                     'include/sluice/sluice.h', 'share/doc/sluice/LICENSE']:
            self.assertTrue((self.prefix / name).is_file(), name)
        modules = {path.name for path in (self.prefix / 'lib/sluice').iterdir()}
        built = {path.name for path in pathlib.Path(BUILD).glob('sluice_*.so')}
        self.assertEqual(modules, built)
        if 'sluice_window.so' in modules:
            for name in ['applications/sluice.desktop', 'icons/hicolor/scalable/apps/sluice.svg',
                         'mime/packages/sluice.xml']:
                self.assertTrue((self.prefix / 'share' / name).is_file(), name)

    def test_names_no_folder_of_the_build(self):
        for path in self.prefix.rglob('*'):
            if path.is_file():
                data = path.read_bytes()
                for folder in (BUILD, SOURCE):
                    self.assertNotIn(os.path.realpath(folder).encode() + b'/', data, path)

    def test_is_hardened(self):
        for path in elf_files(self.prefix):
            said = run('readelf', '-Wld', path)
            self.assertIn('GNU_RELRO', said, path)
            self.assertRegex(said, 'BIND_NOW|Flags:.*NOW', path)
            self.assertNotRegex(said, 'R(UN)?PATH', path)
            if path.name == 'sluice':
                self.assertIn('Position-Independent Executable', said)

    def test_opens_its_modules_wherever_it_is_moved(self):
        if not (self.prefix / 'lib/sluice/sluice_hdf5.so').exists():
            self.skipTest('built without HDF5')
        try:
            import h5py
            import numpy
        except ImportError as missing:
            self.skipTest(str(missing))
        volume = os.path.join(self.folder.name, 'ball.h5')
        with h5py.File(volume, 'w') as file:
            file['ball'] = numpy.arange(4 * 5 * 6, dtype='u1').reshape(4, 5, 6)
        for place in ('prefix', 'elsewhere/deep'):
            moved = pathlib.Path(self.folder.name) / place
            if moved != self.prefix:
                shutil.copytree(self.prefix, moved, symlinks=True)
            self.assertIn('6 x 5 x 4 voxels', run(moved / 'bin/sluice', 'info', volume, env=self.environment()))
            package = moved / 'lib/python3/dist-packages'
            if package.is_dir():
                said = run('/usr/bin/python3', '-B', '-c', f'import sluice; print(sluice.open({volume!r}).dims)',
                           env=self.environment(PYTHONPATH=str(package)), cwd=self.folder.name)
                self.assertEqual(said, '(6, 5, 4)\n')

    def test_wheel_goes_into_an_environment(self):
        if not (self.prefix / 'lib/python3/dist-packages/sluice').is_dir():
            self.skipTest('built without Python')
        if subprocess.run(['/usr/bin/python3', '-m', 'wheel', 'version'], capture_output=True, check=False).returncode != 0:
            self.skipTest('python3-wheel is not installed')
        wheel = run(pathlib.Path(SOURCE) / 'tools/wheel.sh', BUILD, self.folder.name + '/wheels').strip()
        place = pathlib.Path(self.folder.name) / 'environment'
        run('/usr/bin/python3', '-m', 'venv', '--system-site-packages', place)
        run(place / 'bin/pip', '--quiet', 'install', '--no-index', '--no-deps', wheel)
        volume = 'synth:shells,dims=32x32x32'
        said = run(place / 'bin/python', '-c', f'import sluice; sluice.open({volume!r}).save("wheel.png", threshold=90)\n'
                   'print(sluice.__file__)', cwd=self.folder.name, env=self.environment())
        self.assertTrue(said.startswith(str(place)), said)
        run(self.prefix / 'bin/sluice', 'render', '-q', volume, '-o', 'program.png', '--threshold', '90',
            cwd=self.folder.name, env=self.environment())
        self.assertEqual((pathlib.Path(self.folder.name) / 'wheel.png').read_bytes(),
                         (pathlib.Path(self.folder.name) / 'program.png').read_bytes())
        if (self.prefix / 'lib/sluice/sluice_hdf5.so').exists():
            self.assertIn('sluice/sluice_hdf5.so', run('/usr/bin/python3', '-m', 'zipfile', '-l', wheel))

    def test_goes_where_destdir_says(self):
        stage = pathlib.Path(self.folder.name) / 'stage'
        run(CMAKE, '--install', BUILD, '--prefix', '/opt/there', env={**os.environ, 'DESTDIR': str(stage)})
        staged = {path.relative_to(stage / 'opt/there') for path in stage.rglob('*') if path.is_file()}
        self.assertEqual(staged, {path.relative_to(self.prefix) for path in self.prefix.rglob('*') if path.is_file()})
        self.assertNotIn(str(stage), (stage / 'opt/there/lib/pkgconfig/sluice.pc').read_text())

    def test_is_found_by_pkg_config(self):
        if shutil.which('pkg-config') is None:
            self.skipTest('pkg-config is not installed')
        moved = pathlib.Path(self.folder.name) / 'for pkg-config'
        shutil.copytree(self.prefix, moved, symlinks=True)
        environment = self.environment(PKG_CONFIG_PATH=str(moved / 'lib/pkgconfig'), LD_LIBRARY_PATH=str(moved / 'lib'))
        source = pathlib.Path(self.folder.name) / 'one.cpp'
        source.write_text('#include <sluice/sluice.h>\n#include <cstdio>\nint main() {\n'
                          '  const sluice::Volume volume("synth:shells,dims=32x32x32");\n'
                          '  std::printf("%d\\n", int(volume.info().dims[2]));\n'
                          '  try {\n    const sluice::Volume none("none.nrrd");\n'
                          '  } catch (const sluice::Error& error) {\n    std::puts(error.what());\n  }\n}\n')
        for name, is_shared in [('sluice', True), ('sluice-static', False)]:
            self.assertRegex(run('pkg-config', '--modversion', name, env=environment), r'^\d+\.\d+\.\d+\n$')
            run('sh', '-c', f"eval '{CXX}' -std=c++20 one.cpp -o one $(pkg-config --cflags --libs {name})", env=environment,
                cwd=self.folder.name)
            self.assertRegex(run('./one', cwd=self.folder.name, env=environment), r'^32\nnone\.nrrd: .*\n$')
            self.assertEqual('libsluice.so.0.1' in run('readelf', '-Wd', self.folder.name + '/one'), is_shared, name)

    def test_shared_library_exports_the_public_functions_alone(self):
        library = self.prefix / 'lib/libsluice.so'
        self.assertIn('[libsluice.so.0.1]', run('readelf', '-Wd', library))
        exported = set(re.findall(r' [TWVBDR] (.*?)(?:@@.*)?$', run('nm', '-DC', '--defined-only', library), re.M))
        # The members of the classes; none of their public functions is inline.
        declared = set()
        for header, owner in [('image', 'Image'), ('renderer', 'Renderer'), ('volume', 'Volume'), ('in_situ', 'Ranks')]:
            text = re.sub(r'//.*', '', (self.prefix / f'include/sluice/{header}.h').read_text())
            body = re.search(rf'^(?:class|struct) {owner} {{(.*?)(?:^ private:|^}};)', text, re.M | re.S)[1]
            declared |= {f'sluice::{owner}::{name}' for name in
                         re.findall(r'^  (?! )[\w:<>&\[\] ]*?(~?\w+|operator=)\(', body, re.M)}
        self.assertEqual({re.sub(r'(\[abi:\w+\])?\(.*', '', name) for name in exported if 'SLUICE_0.1' != name}, declared)

    def test_desktop_files_are_valid(self):
        share = self.prefix / 'share'
        if not (share / 'applications').exists():
            self.skipTest('built without the window')
        for program, file in [('desktop-file-validate', 'applications/sluice.desktop'),
                              ('xmllint', 'mime/packages/sluice.xml'),
                              ('xmllint', 'icons/hicolor/scalable/apps/sluice.svg')]:
            with self.subTest(file):
                if shutil.which(program) is None:
                    self.skipTest(f'{program} is not installed')
                run(program, *(['--noout'] if program == 'xmllint' else []), share / file)
        if shutil.which('update-mime-database') is None:
            self.skipTest('update-mime-database is not installed')
        mime = pathlib.Path(self.folder.name) / 'mime'
        shutil.copytree(share / 'mime', mime)
        run('update-mime-database', mime)
        self.assertIn('application/x-nrrd:*.nhdr', (mime / 'globs').read_text())


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1] + sys.argv[5:])

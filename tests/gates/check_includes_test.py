#!/usr/bin/env python3
"""The include gate catches what it is there for."""
import pathlib
import tempfile
import unittest

from check_includes import check


class IncludeGate(unittest.TestCase):
    def complaints(self, files):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            everything = {'src/base/a.h': '', 'io/a.h': '', 'cache/a.h': '', 'src/volume/a.h': '', 'src/gl/a.h': '',
                          'src/render/a.h': '', 'tools/a.h': '', 'tests/io/a.h': '', **files}
            for name, text in everything.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text('#pragma once\n' + text)
            return check(root)

    def test_passes_what_points_down(self):
        self.assertEqual(self.complaints({
            'io/b.cpp': '#include "io/a.h"\n#include "src/base/a.h"\n#include <vector>\n',
            'src/volume/b.cpp': '#include "io/a.h"\n#include "cache/a.h"\n',
            'src/gl/b.cpp': '#include "src/render/a.h"\n#include <GL/gl.h>\n',
            'tools/b.cpp': '#include "src/gl/a.h"\n#include <CLI/CLI.hpp>\n',
            'tests/io/b.cpp': '#include "io/a.h"\n#include "tests/io/a.h"\n',
            'io/vdb_module.cpp': '#include <openvdb/openvdb.h>\n',
        }), [])

    def test_names_file_line_and_reason(self):
        self.assertEqual(self.complaints({'io/b.cpp': '\n#include "cache/a.h"\n'}),
                         ['io/b.cpp:3: io may include src/base, not cache'])

    def test_catches_what_points_up_or_aside(self):
        for file, include in [('src/base/b.h', 'io/a.h'), ('cache/b.h', 'io/a.h'), ('io/b.h', 'src/volume/a.h'),
                              ('io/b.cpp', 'tools/a.h'), ('src/volume/b.cpp', 'src/render/a.h'),
                              ('src/render/b.cpp', 'src/gl/a.h'), ('src/gl/b.cpp', 'tools/a.h'),
                              ('src/volume/b.cpp', 'tests/io/a.h'), ('tools/b.cpp', 'tests/io/a.h'),
                              ('io/b.cpp', 'a.h'), ('io/b.cpp', '../src/base/a.h'), ('io/b.cpp', 'io/gone.h')]:
            with self.subTest(file=file, include=include):
                self.assertEqual(len(self.complaints({file: f'# include "{include}"\n'})), 1)

    def test_catches_libraries_where_they_do_not_belong(self):
        for file, include in [('src/render/b.cpp', 'GL/gl.h'), ('tools/b.cpp', 'EGL/egl.h'),
                              ('io/b.cpp', 'openvdb/openvdb.h'), ('tests/io/b.cpp', 'openvdb/openvdb.h'),
                              ('src/volume/b.cpp', 'png.h'), ('src/render/b.cpp', 'OpenEXR/ImfArray.h'),
                              ('io/b.cpp', 'CLI/CLI.hpp')]:
            with self.subTest(file=file, include=include):
                self.assertEqual(len(self.complaints({file: f'#include <{include}>\n'})), 1)

    def test_catches_stray_folders_and_missing_guards(self):
        self.assertEqual(self.complaints({'src/odd/b.cpp': ''}), ['src/odd/b.cpp:1: in a folder that is no layer'])
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / 'io').mkdir()
            (pathlib.Path(folder) / 'io/b.h').write_text('int x;\n')
            self.assertEqual(check(pathlib.Path(folder)), ['io/b.h:1: no #pragma once'])


if __name__ == '__main__':
    unittest.main()

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
            everything = {'include/sluice/a.h': '', 'include/sluice/error.h': '', 'src/library/a.h': '', 'src/base/a.h': '', 'io/a.h': '', 'io/files/a.h': '', 'io/zarr/a.h': '', 'cache/model/a.h': '',
                          'cache/policies/a.h': '', 'src/index/a.h': '', 'src/volume/a.h': '', 'src/device/a.h': '', 'src/gl/a.h': '', 'src/render/a.h': '', 'tools/a.h': '', 'tests/io/a.h': '', **files}
            for name, text in everything.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text('#pragma once\n' + text)
            return check(root)

    def test_passes_what_points_down(self):
        self.assertEqual(self.complaints({
            'io/b.cpp': '#include "io/a.h"\n#include "io/files/a.h"\n#include "src/base/a.h"\n#include <vector>\n',
            'cache/model/b.cpp': '#include "cache/policies/a.h"\n',
            'src/index/b.cpp': '#include "src/volume/a.h"\n',
            'src/render/b.cpp': '#include "src/index/a.h"\n#include "cache/model/a.h"\n',
            'src/gl/b.cpp': '#include "src/device/a.h"\n#include <GL/gl.h>\n',
            'tools/b.cpp': '#include "src/gl/a.h"\n#include <CLI/CLI.hpp>\n',
            'tests/io/b.cpp': '#include "io/a.h"\n#include "tests/io/a.h"\n',
            'io/vdb/vdb_module.cpp': '#include <openvdb/openvdb.h>\n',
        }), [])

    def test_passes_public_headers_from_themselves_and_from_above(self):
        self.assertEqual(self.complaints({
            'include/sluice/b.h': '#include <sluice/a.h>\n#include <stop_token>\n',
            'src/library/b.cpp': '#include <sluice/a.h>\n#include "src/gl/a.h"\n',
            'src/base/error.h': '#include <sluice/error.h>\n',
            'tools/b.cpp': '#include <sluice/a.h>\n#include "src/library/a.h"\n',
        }), [])

    def test_catches_what_shows_through_public_headers(self):
        for include in ['"src/base/a.h"', '"io/a.h"', '"cache/model/a.h"', '"a.h"', '"include/sluice/a.h"', '<src/base/a.h>',
                        '<fmt/format.h>', '<zlib.h>', '<sluice/gone.h>']:
            with self.subTest(include=include):
                self.assertEqual(len(self.complaints({'include/sluice/b.h': f'#include {include}\n'})), 1)

    def test_catches_layers_that_look_at_what_stands_above_them(self):
        for file in ['src/base/b.cpp', 'io/b.cpp', 'src/render/b.cpp', 'src/gl/b.cpp']:
            with self.subTest(file=file):
                self.assertEqual(len(self.complaints({file: '#include <sluice/a.h>\n'})), 1)
                self.assertEqual(len(self.complaints({file: '#include "src/library/a.h"\n'})), 1)
        self.assertEqual(len(self.complaints({'io/b.cpp': '#include <sluice/error.h>\n'})), 1)

    def test_catches_sessions_made_beside_the_scene(self):
        for line in ['Session plain(step, device, pool, options);', 'auto s = std::make_unique<Session>(step);',
                     'device = makeDevice(arguments, pool);']:
            with self.subTest(line=line):
                self.assertEqual(len(self.complaints({'tools/commands/b.cpp': line + '\n'})), 1)
                self.assertEqual(self.complaints({'src/library/drawing/scene/scene.cpp': line + '\n'}), [])
                self.assertEqual(self.complaints({'tools/bench/b.cpp': line + '\n'}), [])

    def test_names_file_line_and_reason(self):
        self.assertEqual(self.complaints({'io/files/b.cpp': '\n#include "cache/model/a.h"\n'}),
                         ['io/files/b.cpp:3: io/files may include src/base, not cache/model'])

    def test_catches_what_points_up_or_aside(self):
        for file, include in [('src/base/b.h', 'io/a.h'), ('cache/model/b.h', 'io/a.h'), ('io/b.h', 'src/volume/a.h'),
                              ('cache/policies/b.h', 'cache/model/a.h'), ('io/files/b.h', 'io/zarr/a.h'),
                              ('src/volume/b.cpp', 'io/files/a.h'), ('src/volume/b.cpp', 'src/index/a.h'),
                              ('io/b.cpp', 'tools/a.h'), ('src/volume/b.cpp', 'src/render/a.h'),
                              ('src/render/b.cpp', 'src/gl/a.h'), ('src/gl/b.cpp', 'src/render/a.h'), ('src/gl/b.cpp', 'tools/a.h'),
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

#!/usr/bin/env python3
"""The document gate catches what it is there for."""
import pathlib
import tempfile
import unittest

from check_docs import check


class DocumentGate(unittest.TestCase):
    def complaints(self, text):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in ('src/render/frame.h', 'tools/setup.sh', 'docs/format.md', 'LICENSE'):
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text('')
            (root / 'README.md').write_text(text)
            return check(root)

    def test_passes_what_exists_and_what_is_no_file(self):
        self.assertEqual(self.complaints(
            'Read `src/render/frame.h`, `src/render/frame.*`, `src/render/`, run `tools/setup.sh --help`,\n'
            'see [format](docs/format.md#top), [there](https://example.org/x), `a/b`, `x.raw`, `README.md`.\n'
            'Built: `build/release/sluice`, `volume/2`.\n```\ntools/gone.sh\n```\n'), [])

    def test_catches_what_is_gone(self):
        for text in ('`src/render/gone.h`', '`src/gone/*.h`', '[x](docs/gone.md)', '`CHANGES.md`', 'run `tools/gone.sh F`'):
            with self.subTest(text=text):
                self.assertEqual(len(self.complaints(text)), 1)

    def test_names_file_and_line(self):
        self.assertEqual(self.complaints('\n`tools/gone.sh`'), ['README.md:2: tools/gone.sh does not exist'])


if __name__ == '__main__':
    unittest.main()

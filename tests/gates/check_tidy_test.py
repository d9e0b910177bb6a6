#!/usr/bin/env python3
"""The clang-tidy gate catches a fault in any file of a group, also where local names clash."""
import json
import pathlib
import shutil
import sys
import tempfile
import unittest

from check_tidy import check, digest_of, missing, sources_of

CLEAN = 'namespace { struct Local { int a = 0; }; }\nint NAME() { return Local{}.a; }\n'
FAULTY = ('#include <string>\n#include <utility>\nnamespace { struct Local { std::string a; }; }\n'
          'std::string NAME(std::string s) { Local l; l.a = std::move(s); return s; }\n')


class TidyGate(unittest.TestCase):
    def said(self, sources, seen=()):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            shutil.copy(pathlib.Path(__file__).parents[2] / '.clang-tidy', root)
            (root / 'io').mkdir()
            commands = []
            for name, text in sources.items():
                (root / 'io' / name).write_text(text.replace('NAME', name.split('.')[0]))
                commands.append({'directory': str(root), 'file': f'io/{name}', 'command': f'c++ -I{root} -c io/{name}'})
            (root / 'compile_commands.json').write_text(json.dumps(commands))
            return check(root, root, seen={digest_of(root, root / 'io' / name) for name in seen})

    def test_says_nothing_of_clean_sources(self):
        self.assertEqual(self.said({'a.cpp': CLEAN, 'b.cpp': CLEAN}), '')

    def test_names_the_faulty_one(self):
        said = self.said({'a.cpp': CLEAN, 'b.cpp': FAULTY, 'c.cpp': 'int c() { return 1; }\n'})
        self.assertIn('io/b.cpp:4', said)
        self.assertNotIn('io/a.cpp', said)

    def test_leaves_out_what_was_clean_until_it_changes(self):
        sources = {'a.cpp': FAULTY, 'b.cpp': FAULTY}
        said = self.said(sources, seen=['a.cpp'])
        self.assertIn('io/b.cpp:4', said)
        self.assertNotIn('io/a.cpp', said)
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            texts = {'.clang-tidy': 'Checks: a', 's.cpp': 'int a;', 's.h': 'int b;'}
            found = set()
            for changed in (None, *texts):
                for name, text in texts.items():
                    (root / name).write_text(text + ('!' if name == changed else ''))
                found.add(digest_of(root, root / 's.cpp'))
            self.assertEqual(len(found), 4)

    def test_looks_into_batches(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            (root / 'io').mkdir()
            (root / 'Unity').mkdir()
            for name in ('a', 'b'):
                (root / f'io/{name}.cpp').write_text('')
            unit = root / 'Unity/unity_0_cxx.cxx'
            unit.write_text(f'/* generated */\n\n#include "{root}/io/a.cpp"\n\n#include "{root}/io/b.cpp"\n')
            (root / 'compile_commands.json').write_text(
                json.dumps([{'directory': str(root), 'file': str(unit), 'command': f'c++ -I{root} -c {unit}'}]))
            self.assertEqual(list(sources_of(root, root)),
                             [(root / f'io/{name}.cpp', [(f'-I{root}',)]) for name in ('a', 'b')])

    def test_source_that_does_not_compile_is_a_fault(self):
        self.assertIn('a.cpp', self.said({'a.cpp': 'int a( {\n', 'b.cpp': CLEAN}))


if __name__ == '__main__':
    if missing(pathlib.Path('.')) and 'installed' in missing(pathlib.Path('.')):
        print(missing(pathlib.Path('.')))
        sys.exit(77)
    unittest.main()

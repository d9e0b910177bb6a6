#!/usr/bin/env python3
"""The gate of local names in batches catches what it is there for."""
import pathlib
import tempfile
import unittest

from check_batches import check

CMAKE = 'sluice_layer(a\n  SOURCES one.cpp two.cpp  # and no more\n  DEPENDS sluice_base)\n'


class BatchesGate(unittest.TestCase):
    def complaints(self, one, two, apart='', folder='src/a', cmake=CMAKE):
        with tempfile.TemporaryDirectory() as root:
            root = pathlib.Path(root)
            (root / folder).mkdir(parents=True)
            (root / 'CMakeLists.txt').write_text(f'set(SLUICE_APART\n  # src\n  {apart})\n')
            (root / folder / 'CMakeLists.txt').write_text(cmake)
            for name, text in (('one', one), ('two', two)):
                (root / folder / f'{name}.cpp').write_text(f'namespace {{\n{text}\n}}  // namespace\n')
            return check(root)

    def test_names_both_places(self):
        found = self.complaints('constexpr int kSide = 2;', '\nconstexpr int kSide = 3;')
        self.assertEqual(len(found), 1)
        self.assertTrue(found[0].startswith('src/a/two.cpp:3: kSide is local to src/a/one.cpp:2 too'), found)

    def test_catches_constants_types_and_functions(self):
        for text in ['constexpr int kA = 1, kB = 2;', 'struct Row {', 'enum class Kind { kA };', 'class Run final : public Job {',
                     'double safe(double step) {', 'template <class T>\nT twice(T value) {',
                     'std::vector<int> sorted(const std::vector<int>& all,\n                        bool up) {']:
            with self.subTest(text=text):
                self.assertTrue(self.complaints(text, text))

    def test_lets_overloads_aliases_and_what_is_not_local_be(self):
        for one, two in [('int of(int a) {', 'int of(double a) {'), ('using Json = int;', 'using Json = int;'),
                         ('}  // namespace\nstruct A {', '}  // namespace\nstruct A {'), ('  int kSide = 1;', '  int kSide = 1;'),
                         ('int of(int a) {', 'int other(int a) {')]:
            with self.subTest(one=one):
                self.assertEqual(self.complaints(one, two), [])

    def test_lets_sources_be_that_are_compiled_apart(self):
        self.assertEqual(self.complaints('struct Row {', 'struct Row {', apart='two'), [])

    def test_lets_namespaces_of_their_own_be(self):
        one, two = ('namespace sluice%s {\nnamespace {\nstruct Row {\n};\n}  // namespace' % own for own in ('', '::two'))
        self.assertEqual(self.complaints(one, two), [])
        self.assertTrue(self.complaints(one, one))

    def test_looks_at_tests(self):
        cmake = CMAKE.replace('sluice_layer', 'sluice_test')
        self.assertTrue(self.complaints('struct Row {', 'struct Row {', folder='tests/a', cmake=cmake))


if __name__ == '__main__':
    unittest.main()

#!/usr/bin/env python3
"""The gate of what is done in one place catches what it is there for."""
import pathlib
import tempfile
import unittest

from check_once import check, uncalled


class OnceGate(unittest.TestCase):
    def complaints(self, file, text):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / file
            path.parent.mkdir(parents=True)
            path.write_text(text)
            return check(pathlib.Path(folder))

    def test_names_file_line_and_what_to_do(self):
        self.assertEqual(self.complaints('io/b.cpp', '\nstd::thread other(work);\n'),
                         ['io/b.cpp:2: threads are started by src/base/threads/threads.h; take a WorkerPool'])

    def test_catches_each_way_to_start_a_thread(self):
        for text in ['std::jthread a(work);', 'std::vector<std::thread> threads;', 'auto a = std::async(work);',
                     'pthread_create(&a, nullptr, work, nullptr);', '#include <future>']:
            with self.subTest(text=text):
                self.assertEqual(len(self.complaints('src/render/b.h', text)), 1)

    def test_catches_locks_that_clang_does_not_check(self):
        for text in ['std::mutex mutex_;', 'const std::lock_guard lock(mutex_);', 'std::condition_variable changed_;']:
            with self.subTest(text=text):
                self.assertEqual(len(self.complaints('io/b.cpp', text)), 1)
                self.assertEqual(self.complaints('src/base/threads/mutex.h', text), [])

    def test_catches_loops_that_write(self):
        self.assertEqual(len(self.complaints('io/b.cpp', 'n = ::write(file, bytes.data(), bytes.size());')), 1)

    def test_catches_a_library_that_prints_exits_or_reads_the_environment(self):
        for text in ['const char* a = std::getenv("HOME");', 'std::printf("a");', 'std::fprintf(stderr, "a");', 'std::cerr << a;',
                     'isatty(STDERR_FILENO);', 'std::exit(1);', '_exit(0);', 'std::abort();', 'fputs("a", stderr);']:
            with self.subTest(text=text):
                for file in ['src/render/b.cpp', 'io/b.cpp', 'cache/model/b.cpp', 'include/sluice/b.h']:
                    self.assertEqual(len(self.complaints(file, text)), 1)
                self.assertEqual(self.complaints('tools/b.cpp', text), [])

    def test_passes_what_only_looks_like_it(self):
        for text in ['snprintf(a, 3, "b");', 'std::atexit(f);', 'aborted(a);', '// std::exit(1)', 'setenv("A", "b", 0);']:
            with self.subTest(text=text):
                self.assertEqual(self.complaints('io/b.cpp', text), [])

    def test_passes_the_one_place_the_tests_and_words(self):
        for file, text in [('src/base/threads/threads.cpp', 'return std::thread(body);'), ('tests/io/b.cpp', 'std::thread a;'),
                           ('io/b.cpp', '// unlike std::thread'), ('io/b.cpp', 'std::thread::id self;')]:
            with self.subTest(file=file):
                self.assertEqual(self.complaints(file, text), [])

    def test_catches_functions_that_are_loaded_for_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / 'src/gl/contexts').mkdir(parents=True)
            (root / 'src/gl/contexts/gl_functions.h').write_text('#define ALL(X) \\\n  X(Clear, CLEAR) \\\n  X(Hint, HINT)\n')
            (root / 'src/gl/contexts/gl_functions.cpp').write_text('')
            (root / 'src/gl/b.cpp').write_text('gl_.Clear(0);\n')
            self.assertEqual(uncalled(root), ['src/gl/contexts/gl_functions.h:3: Hint has no caller'])


if __name__ == '__main__':
    unittest.main()

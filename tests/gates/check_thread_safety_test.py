#!/usr/bin/env python3
"""The thread safety gate catches what it is there for."""
import json
import pathlib
import shutil
import sys
import tempfile
import unittest

from check_thread_safety import check

MUTEX = pathlib.Path(__file__).resolve().parents[2] / 'src/base/threads/mutex.h'
HEADER = '''#pragma once
#include "src/base/threads/mutex.h"
class Counter {
 public:
  void add();
 private:
  void addLocked() SLUICE_REQUIRES(mutex_) { ++count_; }
  sluice::Mutex mutex_;
  sluice::Condition changed_;
  int count_ SLUICE_GUARDED_BY(mutex_) = 0;
};
'''


class ThreadSafetyGate(unittest.TestCase):
    def said(self, body):
        """What the gate says of Counter::add() with this body."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            (root / 'src/base/threads').mkdir(parents=True)
            shutil.copy(MUTEX, root / 'src/base/threads/mutex.h')
            (root / 'src/base/counter.h').write_text(HEADER)
            (root / 'src/base/counter.cpp').write_text(
                f'#include "src/base/counter.h"\nvoid Counter::add() {{ {body} }}\n')
            (root / 'compile_commands.json').write_text(json.dumps(
                [{'directory': str(root), 'file': 'src/base/counter.cpp', 'command': 'c++ -c src/base/counter.cpp'}]))
            return check(root, root)

    def test_passes_what_is_done_under_the_lock(self):
        self.assertEqual(self.said('const sluice::MutexLock lock(mutex_); ++count_; addLocked();'), '')
        self.assertEqual(self.said('sluice::MutexLock lock(mutex_); while (count_ > 0) changed_.wait(lock);'), '')

    def test_catches_what_is_not(self):
        for body in ['++count_;', 'addLocked();', 'sluice::MutexLock lock(mutex_); lock.unlock(); ++count_;']:
            with self.subTest(body=body):
                self.assertIn('src/base/counter.cpp:2', self.said(body))


if __name__ == '__main__':
    if shutil.which('clang++') is None:
        print('clang++ is not installed (tools/setup.sh installs it)')
        sys.exit(77)
    unittest.main()

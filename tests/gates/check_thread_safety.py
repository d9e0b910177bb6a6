#!/usr/bin/env python3
"""What threads share is touched under its mutex: clang's thread safety analysis finds nothing.

  check_thread_safety.py ROOT BUILD_FOLDER [--jobs N]

src/base/threads/mutex.h has the annotations that it reads. Only sources that lock, or whose own header
does, are read: members that are guarded are private. Prints what clang says; exit status 1 when it
says something, 77 when it is not installed.
"""
import argparse
import concurrent.futures
import pathlib
import re
import shutil
import subprocess
import sys

from check_tidy import sources_of

LOCKS = re.compile(r'\b(MutexLock|Mutex|SLUICE_GUARDED_BY|SLUICE_REQUIRES|SingleFlightCache)\b')


def locks(path):
    """Whether a source or the header of its name has to do with a mutex."""
    both = [path, path.with_suffix('.h')]
    return any(file.is_file() and LOCKS.search(file.read_text(errors='replace')) for file in both)


def check_source(root, path, flags):
    """What clang says of one source; empty when nothing."""
    words = [word for flag in flags for word in flag]
    said = subprocess.run(['clang++', '-std=c++20', '-fsyntax-only', '-Wno-everything', '-Wthread-safety', '-Werror=thread-safety',
                           f'-I{root}', *words, path], capture_output=True, text=True, check=False)
    return said.stderr if said.returncode != 0 or 'thread-safety' in said.stderr else ''


def check(root, build, jobs=2):
    """All that clang says of the sources that `build` compiles."""
    root = root.resolve()
    locking = sorted(source for source in sources_of(root, build) if locks(source[0]))
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return ''.join(pool.map(lambda source: check_source(root, *source), locking))


if __name__ == '__main__':
    parser = argparse.ArgumentParser()
    parser.add_argument('root', type=pathlib.Path)
    parser.add_argument('build', type=pathlib.Path)
    parser.add_argument('--jobs', type=int, default=2)
    arguments = parser.parse_args()
    if shutil.which('clang++') is None:
        print('clang++ is not installed (tools/setup.sh installs it)')
        sys.exit(77)
    found = check(arguments.root, arguments.build, arguments.jobs)
    print(found, end='')
    sys.exit(1 if found else 0)

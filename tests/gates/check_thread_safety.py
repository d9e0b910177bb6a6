#!/usr/bin/env python3
"""What threads share is touched under its mutex: clang's thread safety analysis finds nothing.

  check_thread_safety.py ROOT BUILD_FOLDER [--jobs N]

src/base/threads/mutex.h has the annotations that it reads. Only sources that lock, or whose own header
does, are read: members that are guarded are private. Several are read at once, because their headers take
nearly all of the time; where their local names clash, the group is halved until they do not. Prints what clang says; exit status 1 when it
says something, 77 when it is not installed.
"""
import argparse
import concurrent.futures
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from check_tidy import sources_of, unit_of

GROUP = 8
LOCKS = re.compile(r'\b(MutexLock|Mutex|SLUICE_GUARDED_BY|SLUICE_REQUIRES|SingleFlightCache)\b')


def locks(path):
    """Whether a source or the header of its name has to do with a mutex."""
    both = [path, path.with_suffix('.h')]
    return any(file.is_file() and LOCKS.search(file.read_text(errors='replace')) for file in both)


def check_group(root, scratch, group):
    """What clang says of the sources of `group`; empty when nothing."""
    unit, words = unit_of(root, scratch, group)
    said = subprocess.run(['clang++', '-fsyntax-only', '-Wno-everything', '-Wthread-safety', '-Werror=thread-safety',
                           *words, unit], capture_output=True, text=True, check=False)
    if said.returncode == 0:
        return ''
    if len(group) == 1:
        return said.stderr
    half = len(group) // 2
    return check_group(root, scratch, group[:half]) + check_group(root, scratch, group[half:])


def check(root, build, jobs=2):
    """All that clang says of the sources that `build` compiles."""
    root = root.resolve()
    locking = sorted({path: flags for path, flags in sources_of(root, build) if locks(path)}.items())
    groups = [locking[start:start + GROUP] for start in range(0, len(locking), GROUP)]
    with tempfile.TemporaryDirectory() as scratch, concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return ''.join(pool.map(lambda group: check_group(root, pathlib.Path(scratch), group), groups))


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

#!/usr/bin/env python3
"""What one place does, no other does: threads are started in src/base/threads, and so on.

  check_once.py ROOT

Prints each line that does it elsewhere, as FILE:LINE: reason; exit status 1 when there is one.
"""
import pathlib
import re
import sys

# What is done in one place: a pattern of code, the files that may, and what the others use.
ONCE = [
    (r'\bstd::(thread|jthread)\b(?!::)|\bstd::async\b|\bpthread_create\b|#\s*include\s*<future>',
     ['src/base/threads/threads.h', 'src/base/threads/threads.cpp', 'src/base/threads/worker_pool.h', 'src/base/threads/worker_pool.cpp',
      'src/base/threads/deadline.h', 'io/web/http_client.h'],
     'threads are started by src/base/threads/threads.h; take a WorkerPool'),
    (r'\bstd::(mutex|shared_mutex|recursive_mutex|lock_guard|scoped_lock|unique_lock|condition_variable\w*)\b',
     ['src/base/threads/mutex.h'], 'clang checks the mutex of src/base/threads/mutex.h, not this one'),
    (r'::p?write\(\w+, .*\.data\(\)|\bpwrite\(', ['src/base/files/descriptor.cpp', 'tools/command_line/console.cpp'],
     'writing all of something is done by src/base/files/descriptor.h'),
]
# What the program may and the library may not: a pattern of code, the files of the library that
# may, and what it does instead. A failed CHECK says so and aborts; drivers are tried in a child.
PROGRAM = 'tools/'
ONCE_IN_PROGRAM = [
    (r'\bgetenv\(', [], 'the library does not read the environment: take an option, tools/command_line/environment.h reads it'),
    (r'\bf?printf\(|\bfputs\(|\bputs\(|\bstd::(cout|cerr|clog)\b|\bfmt::print\b|\bSTD(OUT|ERR)_FILENO\b', ['src/base/error.cpp', 'src/gl/contexts/child_process.cpp'],
     'the library does not print: return it, or take a function that is told'),
    (r'\b_?[eE]xit\(|\bquick_exit\(|\babort\(|\bterminate\(', ['src/base/error.cpp', 'src/gl/contexts/child_process.cpp'],
     'the library does not end the program: throw Error'),
]
# A list of functions to load: each has a caller.
LISTED = 'src/gl/contexts/gl_functions.h'
CALLERS = ['src/gl', 'tests/gl']
COMMENT = re.compile(r'//.*$')


def check(root):
    """A list of complaints about the sources under `root`; tests may do as they like."""
    complaints = []
    for top in ('include', 'src', 'io', 'cache', 'tools', 'python'):
        for path in sorted((root / top).rglob('*')):
            if path.suffix not in ('.h', '.cpp'):
                continue
            file = path.relative_to(root).as_posix()
            listed = ONCE + (ONCE_IN_PROGRAM if not file.startswith(PROGRAM) else [])
            rules = [(re.compile(pattern), reason) for pattern, files, reason in listed if file not in files]
            for number, line in enumerate(path.read_text(errors='replace').splitlines(), 1):
                code = COMMENT.sub('', line)
                complaints += [f'{file}:{number}: {reason}' for pattern, reason in rules if pattern.search(code)]
    return complaints


def uncalled(root):
    """A list of complaints about functions that are loaded for nothing."""
    if not (root / LISTED).is_file():
        return []
    files = [path for folder in CALLERS for path in (root / folder).rglob('*') if path.suffix in ('.h', '.cpp')]
    calls = set(re.findall(r'(?:\.|->)(\w+)', ''.join(path.read_text() for path in files if path.stem != 'gl_functions')))
    calls |= set(re.findall(r'\bgl\.(\w+)\(', (root / LISTED).with_suffix('.cpp').read_text()))
    lines = enumerate((root / LISTED).read_text().splitlines(), 1)
    named = ((number, re.match(r'\s+X\((\w+),', line)) for number, line in lines)
    return [f'{LISTED}:{number}: {name[1]} has no caller' for number, name in named if name and name[1] not in calls]


if __name__ == '__main__':
    found = check(pathlib.Path(sys.argv[1])) + uncalled(pathlib.Path(sys.argv[1]))
    print('\n'.join(found))
    sys.exit(1 if found else 0)

#!/usr/bin/env python3
"""clang-tidy finds nothing in the program's sources. The checks are in .clang-tidy.

  check_tidy.py ROOT BUILD_FOLDER [--jobs N]

Nearly all of clang-tidy's time goes into the headers of libraries, so the sources of a folder are
checked several at once, as one translation unit that includes them; where their local names clash,
the group is halved until they do not. Tests are left out: GoogleTest's macros make them slow.
Prints what clang-tidy says; exit status 1 when it says something, 77 when it is not installed.
"""
import argparse
import concurrent.futures
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

GROUP = 10
FOLDERS = re.compile(r'(src|io|cache|tools|python)(/\w+)*/\w+\.cpp$')
BATCHED = re.compile(r'^#include "(.*)"$', re.M)


def flags_of(command):
    """What of a compile command decides how the source reads: paths and definitions."""
    words, flags = iter(shlex.split(command)), []
    for word in words:
        if word in ('-I', '-isystem', '-D'):
            flags.append((word, next(words)))
        elif word.startswith(('-I', '-D')):
            flags.append((word,))
    return flags


def sources_of(root, build):
    """(path, flags) of each source of the program. A batch stands for the sources that it includes."""
    for entry in json.loads((build / 'compile_commands.json').read_text()):
        path = pathlib.Path(entry['directory'], entry['file']).resolve()
        flags = flags_of(entry.get('command') or shlex.join(entry['arguments']))
        batch = BATCHED.findall(path.read_text()) if path.parent.name == 'Unity' else [path]
        for source in map(pathlib.Path, batch):
            if source.is_relative_to(root) and FOLDERS.fullmatch(source.relative_to(root).as_posix()):
                yield source, flags


def groups_of(root, build):
    """Lists of (path, flags), a folder's sources split into groups of at most GROUP."""
    folders = {}
    for path, flags in sources_of(root, build):
        # Of a source that is compiled several times, for instruction sets, the first.
        folders.setdefault(path.parent, {}).setdefault(path, flags)
    for files in folders.values():
        listed = sorted(files.items())
        for start in range(0, len(listed), GROUP):
            yield listed[start:start + GROUP]


def unit_of(root, scratch, group):
    """A source in `scratch` that includes those of `group`, and the words that a compiler needs to read it."""
    unit = scratch / f'{group[0][0].stem}_{len(group)}.cpp'
    unit.write_text(''.join(f'#include "{path}"\n' for path, _ in group))
    flags = list(dict.fromkeys(flag for _, each in group for flag in each))
    return unit, ['-std=c++20', f'-I{root}'] + [word for flag in flags for word in flag]


def check_group(root, scratch, group):
    """What clang-tidy says of the sources of `group`; empty when nothing."""
    unit, words = unit_of(root, scratch, group)
    if len(group) > 1:
        reads = subprocess.run(['clang++', '-fsyntax-only', '-w', *words, unit], capture_output=True, check=False)
        if reads.returncode != 0:
            half = len(group) // 2
            return check_group(root, scratch, group[:half]) + check_group(root, scratch, group[half:])
    tidy = subprocess.run(
        ['clang-tidy', '--quiet', f'--config-file={root}/.clang-tidy', '--checks=-bugprone-suspicious-include',
         f'--header-filter={root}/(include|src|io|cache|tools)/.*', unit, '--', *words],
        capture_output=True, text=True, check=False)
    said = tidy.stdout.strip()
    if tidy.returncode != 0 and not said:
        said = f'clang-tidy failed on {", ".join(str(path) for path, _ in group)}: {tidy.stderr.strip()}'
    return said + '\n' if said else ''


def check(root, build, jobs=2):
    """All that clang-tidy says of the sources that `build` compiles."""
    root = root.resolve()
    with tempfile.TemporaryDirectory() as scratch, concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        said = pool.map(lambda group: check_group(root, pathlib.Path(scratch), group), list(groups_of(root, build)))
        return ''.join(said)


def missing(build):
    """Why the check cannot be made; None when it can."""
    for program in ('clang-tidy', 'clang++'):
        if shutil.which(program) is None:
            return f'{program} is not installed (tools/setup.sh installs it)'
    if not (build / 'compile_commands.json').is_file():
        return f'{build}/compile_commands.json is missing'
    return None


if __name__ == '__main__':
    parser = argparse.ArgumentParser()
    parser.add_argument('root', type=pathlib.Path)
    parser.add_argument('build', type=pathlib.Path)
    parser.add_argument('--jobs', type=int, default=2)
    arguments = parser.parse_args()
    reason = missing(arguments.build)
    if reason:
        print(reason)
        sys.exit(77)
    said = check(arguments.root, arguments.build, arguments.jobs)
    print(said, end='')
    sys.exit(1 if said else 0)

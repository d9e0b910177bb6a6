#!/usr/bin/env python3
"""clang-tidy finds nothing in the program's sources. The checks are in .clang-tidy.

  check_tidy.py ROOT BUILD_FOLDER [--jobs N] [--all] [--record]

Without --all, sources are left out that tidy_seen.txt beside this script lists as clean: each by the
digest of its text, of its own header and of .clang-tidy. What another header changes in them is left
to --all. --record writes the list anew if clang-tidy finds nothing.

Nearly all of clang-tidy's time goes into the headers of libraries, so the sources of a folder are
checked several at once, as one translation unit that includes them; where their local names clash,
the group is halved until they do not. Tests are left out: GoogleTest's macros make them slow.
Prints what clang-tidy says; exit status 1 when it says something, 77 when it is not installed.
"""
import argparse
import concurrent.futures
import hashlib
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
SEEN = pathlib.Path(__file__).with_name('tidy_seen.txt')
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


def digest_of(root, source):
    """A short name of the texts that a source's findings follow from, but for the headers of others."""
    texts = [root / '.clang-tidy', source, source.with_suffix('.h')]
    return hashlib.sha256(b'\0'.join(text.read_bytes() for text in texts if text.is_file())).hexdigest()[:16]


def seen_clean():
    """The digests of the sources in which clang-tidy found nothing."""
    return set(SEEN.read_text().split()[::2]) if SEEN.is_file() else set()


def record(root, build):
    """Lists all sources as clean."""
    lines = {f'{digest_of(root, path)} {path.relative_to(root)}\n' for path, _ in sources_of(root, build)}
    SEEN.write_text(''.join(sorted(lines, key=lambda line: line.split()[1])))


def groups_of(root, build, seen):
    """Lists of (path, flags), a folder's sources that `seen` has not, split into groups of at most GROUP."""
    folders = {}
    for path, flags in sources_of(root, build):
        if digest_of(root, path) in seen:
            continue
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


def check(root, build, jobs=2, seen=frozenset()):
    """All that clang-tidy says of the sources that `build` compiles and `seen` has no digest of."""
    root = root.resolve()
    with tempfile.TemporaryDirectory() as scratch, concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        said = pool.map(lambda group: check_group(root, pathlib.Path(scratch), group), list(groups_of(root, build, seen)))
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
    parser.add_argument('--all', action='store_true')
    parser.add_argument('--record', action='store_true')
    arguments = parser.parse_args()
    reason = missing(arguments.build)
    if reason:
        print(reason)
        sys.exit(77)
    said = check(arguments.root, arguments.build, arguments.jobs, set() if arguments.all else seen_clean())
    print(said, end='')
    if arguments.record and not said:
        record(arguments.root.resolve(), arguments.build)
    sys.exit(1 if said else 0)

#!/usr/bin/env python3
"""What the documents name exists: files in `backticks` and the targets of links.

  check_docs.py ROOT

A backticked word counts as a file when it holds a slash and begins with a folder of the
repository, or names a file at the top (`README.md`). Stars match; what a build makes is not looked
for. Prints FILE:LINE: reason; exit status 1 when there is one.
"""
import pathlib
import re
import sys

FOLDERS = ('include', 'src', 'io', 'cache', 'tools', 'python', 'tests', 'examples', 'docs', '.ci')
CODE = re.compile(r'`([^`\n]+)`')
LINK = re.compile(r'\]\(([^)\s#]+)[^)]*\)')
TOP_FILE = re.compile(r'[A-Za-z0-9_.-]+\.(md|txt|json|sh|h|cpp)$')


def documents(root):
    """The markdown files at the top and under docs."""
    return sorted(root.glob('*.md')) + sorted((root / 'docs').rglob('*.md'))


def names_in(line):
    """The paths that a line of markdown names."""
    for code in CODE.findall(line):
        for word in code.split():
            word = word.rstrip('.,:;')
            if word.split('/')[0] in FOLDERS and '/' in word and re.fullmatch(r'[\w./*-]+', word):
                yield word
            elif word[:1].isupper() and TOP_FILE.fullmatch(word):
                yield word
    for target in LINK.findall(line):
        if '://' not in target and not target.startswith('mailto:'):
            yield target


def check(root):
    """A list of complaints about the documents under `root`."""
    complaints = []
    for path in documents(root):
        fenced = False
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if line.lstrip().startswith('```'):
                fenced = not fenced
            if fenced:
                continue
            for name in names_in(line):
                here = any(path.parent.glob(name)) if '*' in name else (path.parent / name).exists()
                if not here and not any(root.glob(name.rstrip('/'))):
                    complaints.append(f'{path.relative_to(root)}:{number}: {name} does not exist')
    return complaints


if __name__ == '__main__':
    found = check(pathlib.Path(sys.argv[1]))
    print('\n'.join(found))
    sys.exit(1 if found else 0)

#!/usr/bin/env python3
"""Prints a header with its comments as Doxygen reads them.

  comments.py HEADER

A comment above a declaration becomes `///`, one behind it `///<`, and so do the lines that go on below
the latter. The comment above `#pragma once` describes the file.
"""
import re
import sys

BEHIND = re.compile(r'^(?=\s*[^\s/])(.*?\S\s+)// ?(.*)$')
ALONE = re.compile(r'^(\s*)// ?(.*)$')


def converted(text):
    lines = []
    column = None  # of the comment behind a declaration that may go on
    for line in text.splitlines():
        behind, alone = BEHIND.match(line), ALONE.match(line)
        if behind:
            column = len(behind[1])
            lines.append(f'{behind[1]}///< {behind[2]}')
        elif alone:
            mark = '///<' if column is not None and len(alone[1]) == column else '///'
            lines.append(f'{alone[1]}{mark} {alone[2]}')
        else:
            column = None
            lines.append(line)
    top = next((i for i, line in enumerate(lines) if line == '#pragma once'), None)
    return '\n'.join((['/// \\file'] if top else []) + lines) + '\n'


if __name__ == '__main__':
    with open(sys.argv[1], encoding='utf-8') as header:
        sys.stdout.write(converted(header.read()))

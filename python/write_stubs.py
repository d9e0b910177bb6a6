#!/usr/bin/env python3
"""Writes the stubs of the package, with the keywords of pictures as the built module takes them.

  write_stubs.py MODULE_FOLDER TEMPLATE OUT
"""
import pathlib
import sys

EMPTY = 'class PictureOptions(TypedDict, total=False): ...\n'


def filled(template, types):
    """The template with a field for each keyword that has a type."""
    if EMPTY not in template:
        raise SystemExit(f'write_stubs.py: expected the line {EMPTY!r} in the template, found none')
    fields = [f'    {keyword}: {type_} | None\n' for keyword, type_ in types if type_]
    return template.replace(EMPTY, EMPTY.replace(' ...', '') + ''.join(fields))


if __name__ == '__main__':
    folder, template, out = sys.argv[1:]
    sys.path.insert(0, folder)
    import _sluice
    pathlib.Path(out).write_text(filled(pathlib.Path(template).read_text(), _sluice.keyword_types()))

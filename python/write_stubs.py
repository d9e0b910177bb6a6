#!/usr/bin/env python3
"""Writes the stubs of the package, with the keywords of volumes and pictures as the built module takes them.

  write_stubs.py MODULE_FOLDER TEMPLATE OUT
"""
import pathlib
import sys


def filled(template, name, types):
    """The template with a field of the class for each keyword that has a type."""
    empty = f'class {name}(TypedDict, total=False): ...\n'
    if empty not in template:
        raise SystemExit(f'write_stubs.py: expected the line {empty!r} in the template, found none')
    fields = [f'    {keyword}: {type_} | None\n' for keyword, type_ in types if type_]
    return template.replace(empty, empty.replace(' ...', '') + ''.join(fields))


if __name__ == '__main__':
    folder, template, out = sys.argv[1:]
    sys.path.insert(0, folder)
    import _sluice
    stubs = filled(pathlib.Path(template).read_text(), 'VolumeOptions', _sluice.volume_keyword_types())
    pathlib.Path(out).write_text(filled(stubs, 'PictureOptions', _sluice.keyword_types()))

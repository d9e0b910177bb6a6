#!/usr/bin/env python3
"""Includes point one way only: tools -> src/* -> cache, io -> src/base.

  check_includes.py ROOT

Prints each include that does not, as FILE:LINE: reason; exit status 1 when there is one.
"""
import pathlib
import re
import sys

# Which folders a folder's sources may include from, besides itself. Among the layers of src the
# frame knows nothing of GL, and what lies below the frame knows nothing of it.
BELOW_FRAME = ['src/base', 'cache', 'io', 'src/volume', 'src/classify', 'src/texture', 'src/visibility']
ALLOWED = {
    'src/base': [],
    'cache': ['src/base'],
    'io': ['src/base'],
    'src/volume': BELOW_FRAME,
    'src/classify': BELOW_FRAME,
    'src/texture': BELOW_FRAME,
    'src/visibility': BELOW_FRAME,
    'src/render': BELOW_FRAME,
    'src/gl': BELOW_FRAME + ['src/render'],
    'src/parallel': BELOW_FRAME + ['src/render'],
    'tools': None,  # everything
    'tests': None,
}

# Headers of a library and the places that may know it.
LIBRARIES = {
    r'(GL|GLES\d?|EGL|GLFW|KHR)/': ['src/gl/', 'tests/gl/'],
    r'openvdb/': ['io/vdb_module.cpp', 'tests/support/vdb_writer.cpp'],
    r'(OpenEXR|Imath)/': ['io/', 'tests/io/'],
    r'(png|tiffio)\.h': ['io/', 'tests/io/'],
    r'nifti': ['io/', 'tests/io/'],
    r'mpi\.h': ['src/parallel/', 'tests/parallel/'],
    r'CLI/': ['tools/', 'tests/tools/'],
}
INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')


def layer_of(path):
    """The folder that `path`, relative to the root, belongs to; None outside of all."""
    parts = path.split('/')
    two = '/'.join(parts[:2])
    return two if two in ALLOWED else parts[0] if parts[0] in ALLOWED else None


def fault(file, quote, target, root):
    """Why `file` may not include `target`; None when it may."""
    if quote == '<':
        for pattern, places in LIBRARIES.items():
            if re.match(pattern, target) and not any(file.startswith(place) for place in places):
                return f'<{target}> is known in {", ".join(places)} only'
        return None
    if '..' in target.split('/') or not (root / target).is_file():
        return f'"{target}" is not a path from the root of the repository'
    own, other = layer_of(file), layer_of(target)
    if other == 'tests' and own != 'tests':
        return f'{own} may not include the tests'
    allowed = ALLOWED[own]
    if own == other or allowed is None or other in allowed:
        return None
    return f'{own} may include {", ".join(allowed) or "nothing"}, not {other}'


def check(root):
    """A list of complaints about the sources under `root`."""
    complaints = []
    for top in ('src', 'io', 'cache', 'tools', 'tests'):
        for path in sorted((root / top).rglob('*')):
            if path.suffix not in ('.h', '.cpp'):
                continue
            file = path.relative_to(root).as_posix()
            if layer_of(file) is None:
                complaints.append(f'{file}:1: in a folder that is no layer')
                continue
            lines = path.read_text(errors='replace').splitlines()
            if path.suffix == '.h' and '#pragma once' not in lines:
                complaints.append(f'{file}:1: no #pragma once')
            for number, line in enumerate(lines, 1):
                found = INCLUDE.match(line)
                reason = found and fault(file, found[1], found[2], root)
                if reason:
                    complaints.append(f'{file}:{number}: {reason}')
    return complaints


if __name__ == '__main__':
    found = check(pathlib.Path(sys.argv[1]))
    print('\n'.join(found))
    sys.exit(1 if found else 0)

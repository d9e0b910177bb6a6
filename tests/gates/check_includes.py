#!/usr/bin/env python3
"""Includes point one way only: tools, python, src/view -> include/sluice -> src/* -> cache, io -> src/base, and so within each.

  check_includes.py ROOT

Prints each include that does not, as FILE:LINE: reason; exit status 1 when there is one.
"""
import pathlib
import re
import sys

# Which folders a folder's sources may include from, besides itself and src/base. A folder that
# is not named belongs to none: each part of a layer has its own line. Public headers, which are
# included as <sluice/...>, see each other and the C++ library alone; src/library stands behind them.
PUBLIC = 'include/sluice'
TRANSFER, BLOCKS, BOXES = 'src/classify/transfer', 'src/classify/blocks', 'src/classify/boxes'
ALLOWED = {
    PUBLIC: [],
    'src/base': [],
    'cache/policies': [],
    'cache/model': ['cache/policies'],
    'cache/trace': ['cache/policies'],
    'cache/simulate': ['cache/policies', 'cache/model', 'cache/trace'],
    'io/files': [],
    'io/headers': ['io/files'],
    'io/slices': ['io/files'],
    'io/dicom': ['io/files', 'io/headers'],
    'io/vdb': ['io/files'],
    'io/stores': ['io/files'],
    'io/web': ['io/stores'],
    'io/zarr': ['io/files', 'io/headers', 'io/stores'],
    'io/hdf5': ['io/files', 'io/headers', 'io/stores', 'io/zarr'],
    'io/vtk': ['io/files', 'io/headers', 'io/zarr'],
    'io/synth': [],
    'io/pictures': ['io/files'],
    'io/meshes': ['io/files'],
    'io': ['io/files', 'io/stores', 'io/web', 'io/headers', 'io/slices', 'io/dicom', 'io/hdf5', 'io/vdb', 'io/vtk', 'io/zarr', 'io/synth'],
    'src/volume': [],
    TRANSFER: ['src/volume'],
    BLOCKS: ['src/volume', TRANSFER],
    BOXES: ['src/volume', TRANSFER],
    'src/index': ['src/volume', TRANSFER, BOXES, 'src/visibility'],
    'src/device': ['src/volume'],
    'src/texture': ['cache/model', 'cache/trace', 'src/device', 'src/volume', BLOCKS],
    'src/visibility': ['src/volume', TRANSFER, 'src/device'],
    'src/render': ['cache/model', 'cache/trace', 'src/volume', TRANSFER, BLOCKS, BOXES,
                   'src/device', 'src/index', 'src/texture', 'src/visibility'],
    'src/annotate': [TRANSFER, 'src/device', 'src/render'],
    'src/surface': ['io/meshes', 'src/volume'],
    'src/slicing': ['src/device', 'src/render'],
    'src/parallel': ['src/volume', BLOCKS, 'src/device', 'src/render'],
    'src/gl': ['src/device', 'src/volume'],
    'src/options': [PUBLIC],
    'src/library': [PUBLIC, 'src/options', 'cache/model', 'cache/policies', 'cache/trace', 'io', 'io/files', 'io/meshes', 'io/pictures', 'io/web', 'io/zarr', 'src/volume', TRANSFER, BLOCKS,
                    'src/device',
                    'src/cpu', 'src/gl', 'src/index', 'src/parallel', 'src/render', 'src/surface', 'src/texture', 'src/visibility'],
    'src/view/state': [PUBLIC, 'src/options'],
    'src/view/drawing': [PUBLIC, 'src/options', 'src/view/state'],
    'src/view/window': [PUBLIC, 'src/options', 'src/view/state', 'src/view/drawing', 'src/view/window/panels'],
    'src/view/window/panels': [PUBLIC, 'src/options', 'src/view/state', 'src/view/drawing', 'src/view/window'],
    'src/cpu': ['src/device', 'src/volume'],
    'python': [PUBLIC, 'src/options', 'src/view/state', 'cache/policies', 'cache/trace', 'cache/simulate'],
    'tools': None,  # everything
    'tools/bench': None,
    'tools/command_line': None,
    'tools/commands': None,
    'tools/plan': None,
    'tools/fetch': None,
    'tools/manual': None,
    'tools/options': None,
    'tools/outputs': None,
    'tools/scene': None,
    'tools/pages': None,
    'tests': None,
}

# Folders within a layer, for which the rule is the layer's.
PARTS = {
    'src/view/state/editing': 'src/view/state',
    'src/view/state/files': 'src/view/state',
    'src/view/state/screen': 'src/view/state',
    'src/base/files': 'src/base',
    'src/base/looks': 'src/base',
    'src/base/threads': 'src/base',
    'src/base/memory': 'src/base',
    'src/base/sources': 'src/base',
    'src/base/values': 'src/base',
    'io/headers/meta_image': 'io/headers',
    'io/headers/nifti': 'io/headers',
    'io/headers/nrrd': 'io/headers',
    'io/headers/raw': 'io/headers',
    'io/slices/tiff': 'io/slices',
    'io/zarr/metadata': 'io/zarr',
    'io/zarr/n5': 'io/zarr',
    'io/zarr/levels': 'io/zarr',
    'io/zarr/packing': 'io/zarr',
    'io/zarr/reading': 'io/zarr',
    'src/device/pictures': 'src/device',
    'src/device/shading': 'src/device',
    'src/cpu/kernels': 'src/cpu',
    'src/gl/contexts': 'src/gl',
    'src/gl/shaders': 'src/gl',
    'src/library/drawing': 'src/library',
    'src/library/drawing/cost': 'src/library',
    'src/library/drawing/files': 'src/library',
    'src/library/drawing/scene': 'src/library',
    'src/library/opening': 'src/library',
    'src/library/opening/levels': 'src/library',
    'src/volume/passes': 'src/volume',
    'src/volume/ranges': 'src/volume',
    'src/volume/voxels': 'src/volume',
    'src/visibility/occlusion': 'src/visibility',
    'src/visibility/plenoptic': 'src/visibility',
    'src/parallel/communication': 'src/parallel',
    'src/render/camera': 'src/render',
    'src/render/blocks': 'src/render',
    'src/render/blocks/cut': 'src/render',
    'src/render/blocks/losses': 'src/render',
    'src/render/frame': 'src/render',
    'src/render/light': 'src/render',
    'src/render/session': 'src/render',
}

# The one public header that all know: what they throw is what users catch.
FOR_ALL = {'include/sluice/error.h': ['src/base']}

# Headers of a library and the places that may know it.
LIBRARIES = {
    r'(GL|GLES\d?|EGL|KHR)/': ['src/gl/', 'tests/gl/'],
    r'GLFW/|imgui|backends/imgui': ['src/view/window/'],
    r'openvdb/': ['io/vdb/vdb_library_grids.h', 'io/vdb/vdb_module.cpp', 'io/vdb/vdb_tree_walk.h', 'tests/support/vdb_writer.cpp'],
    r'(OpenEXR|Imath)/': ['io/pictures/', 'tests/io/'],
    r'(png|tiffio)\.h': ['io/', 'tests/io/'],
    r'nifti': ['io/', 'tests/io/'],
    r'cairo': ['src/annotate/'],
    r'hdf5\.h': ['io/hdf5/hdf5_module.cpp', 'io/hdf5/hdf5_objects.h'],
    r'expat': ['io/files/xml_scanner.cpp'],
    r'curl/': ['io/web/http_client.cpp', 'io/web/redirect.cpp', 'io/web/web_module.cpp'],
    r'hwy/': ['src/cpu/', 'tests/cpu/'],
    r'mpi\.h': ['src/parallel/', 'tests/parallel/'],
    r'CLI/': ['tools/', 'tests/tools/'],
    r'pybind11/': ['python/'],
}
# One place makes what draws: commands and the public Renderer go through the Scene. Benches measure the parts
# beneath it, and --verify compares with a second session.
MAKES_SESSION = re.compile(r'make_unique<Session>|\bSession \w+[({]|makeDevice\(')
SESSION_MAKERS = ['src/library/drawing/scene/scene.cpp', 'src/library/drawing/scene/device_choice.', 'tools/bench/',
                  'tools/commands/verification.cpp', 'tests/']
INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')


def layer_of(path):
    """The folder that `path`, relative to the root, belongs to; None outside of all."""
    if path.startswith('tests/'):
        return 'tests'
    folder = path.rpartition('/')[0]
    folder = PARTS.get(folder, folder)
    return folder if folder in ALLOWED else None


def fault(file, quote, target, root):
    """Why `file` may not include `target`; None when it may."""
    if quote == '<' and target.startswith('sluice/'):
        target = f'include/{target}'
        if layer_of(file) in FOR_ALL.get(target, []):
            return None
    elif file.startswith(PUBLIC):
        standard = quote == '<' and re.fullmatch(r'[a-z_]+', target)
        return None if standard else f'a public header may include <sluice/...> and the C++ library, not {target}'
    elif quote == '<':
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
    if own == other or allowed is None or other == 'src/base' or other in allowed:
        return None
    return f'{own} may include {", ".join(["src/base", *allowed])}, not {other}'


def check(root):
    """A list of complaints about the sources under `root`."""
    complaints = []
    for top in ('include', 'src', 'io', 'cache', 'tools', 'python', 'tests'):
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
                if MAKES_SESSION.search(line) and not file.startswith(tuple(SESSION_MAKERS)):
                    complaints.append(f'{file}:{number}: draw through src/library/drawing/scene/scene.h, which makes the session')
                found = INCLUDE.match(line)
                reason = found and fault(file, found[1], found[2], root)
                if reason:
                    complaints.append(f'{file}:{number}: {reason}')
    return complaints


if __name__ == '__main__':
    found = check(pathlib.Path(sys.argv[1]))
    print('\n'.join(found))
    sys.exit(1 if found else 0)

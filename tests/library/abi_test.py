"""The binary interface of the shared library: what a program that was linked to it relies on.

  abi_test.py BUILD_FOLDER SOURCE_FOLDER COMPILER [--write]

The sizes and members of the headers' types, as libabigail reads them from debugging information, and the functions
that the library exports have to equal src/library/abi.txt. --write makes that file anew.
"""
import difflib
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

build, source = map(pathlib.Path, sys.argv[1:3])
compiler = sys.argv[3]
kept = source / 'src/library/abi.txt'

# A value of each type that users make or get; the types within them come along.
TYPES = ('ArrayLayout Cancelled Error Image LentBox LookOptions PictureOptions PicturePlan Progress Ranks RenderReport Renderer '
         'RendererOptions ScreenContext ScreenImage ShownLook SliceOptions SliceValues ValueHistogram Volume VolumeInfo '
         'VolumeOptions VoxelProbe').split()
PROBE = f'''
#include <sluice/sluice.h>
namespace sluice {{
__attribute__((visibility("default"))) void use({', '.join(f'const {name}&' for name in TYPES)}) {{}}
}}
'''


def members_of(type_):
    for member in type_.findall('data-member'):
        variable = member.find('var-decl')
        if variable is not None and member.get('layout-offset-in-bits') is not None:
            yield f"  {variable.get('name')} at {int(member.get('layout-offset-in-bits')) // 8}"


def types_in(scope, outer):
    for child in scope:
        name = f"{outer}::{child.get('name')}"
        if child.tag == 'member-type':
            yield from types_in(child, outer)
        elif child.tag == 'class-decl' and child.get('size-in-bits') and not child.get('is-anonymous'):
            yield name, [f"{name}, {int(child.get('size-in-bits')) // 8} bytes", *members_of(child)]
            yield from types_in(child, name)
        elif child.tag == 'enum-decl' and not child.get('is-anonymous'):
            values = [f"{each.get('name')} = {each.get('value')}" for each in child.findall('enumerator')]
            yield name, [f"{name}: {', '.join(values)}"]


def layouts(folder):
    probe = folder / 'probe.cpp'
    probe.write_text(PROBE)
    subprocess.run([compiler, '-std=c++20', '-g', '-fno-eliminate-unused-debug-types', '-fPIC', '-shared',
                    '-I', source / 'include', probe, '-o', folder / 'probe.so'], check=True)
    text = subprocess.run(['abidw', '--headers-dir', source / 'include/sluice', '--drop-private-types',
                           folder / 'probe.so'], check=True, capture_output=True, text=True).stdout
    found = {}
    for namespace in xml.fromstring(text).iter('namespace-decl'):
        if namespace.get('name') == 'sluice':
            for name, lines in types_in(namespace, 'sluice'):
                if '<' not in name:
                    found[name] = lines
    return [line for name in sorted(found) for line in found[name]]


def functions():
    listed = subprocess.run(['nm', '-D', '-C', '--defined-only', build / 'libsluice.so'], check=True,
                            capture_output=True, text=True).stdout
    return sorted({line.split(maxsplit=2)[2].split('@@')[0] for line in listed.splitlines()
                   if line.split()[1] in 'TW'})


with tempfile.TemporaryDirectory() as folder:
    now = [*layouts(pathlib.Path(folder)), '', *functions()]
if '--write' in sys.argv:
    kept.write_text('\n'.join(now) + '\n')
    sys.exit()
before = kept.read_text().splitlines()
if now != before:
    print(*difflib.unified_diff(before, now, str(kept), 'this build', lineterm=''), sep='\n')
    sys.exit(f'{kept}: expected the binary interface of this build, found another one (above). Programs that were '
             'linked to a released library of this name break: raise the minor version if there is one, and then '
             f'run {sys.argv[0]} {build} {source} {compiler} --write')
print(f'{len(now)} lines equal {kept.name}')

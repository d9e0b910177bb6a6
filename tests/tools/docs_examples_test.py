#!/usr/bin/env python3
"""Every example of the documents and of --help does what it says.

  docs_examples_test.py PROGRAM ROOT

Commands are lines of code blocks that begin with `sluice`, code in a line that begins so and has no placeholder, and the
examples of each command's --help. They run in one folder, in which the volumes that they name are small ones of the same
names; large sizes are made small, nothing else is changed. JSON examples are read by what they are for.
"""
import gzip
import json
import os
import pathlib
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile

PROGRAM, ROOT = sys.argv[1], pathlib.Path(sys.argv[2])
# The gallery's pictures are drawn again by tools/gallery.sh, from volumes that are not here; so are those of datasets.md.
PAGES = [ROOT / 'README.md'] + sorted(page for page in (ROOT / 'docs').glob('*.md') if page.name != 'gallery.md')
SMALLER = [(r'512x512x512', '48x48x48'), (r'512,512,512', '48,48,48'), (r'256x256x225', '48x48x40'), (r'800x600', '48x36'),
           (r'16821,7494,2070', '1682,749,207'), (r'--size 256x256', '--size 64x64')]
SIZE = ' --size 128'
PLACEHOLDER = re.compile(r'\b[A-Z][A-Z]+\b|\.\.\.|…|--host|\bsrun\b')


def run(folder, line, program=PROGRAM):
    """A line of sh, with `sluice` as the program under test."""
    # mpirun asks every X server for GPUs, and ends with one that a test of the window stops meanwhile.
    environment = dict(os.environ, XDG_CACHE_HOME=f'{folder}/cache', XDG_CONFIG_HOME=f'{folder}/config', HWLOC_COMPONENTS='-gl',
                       OMPI_MCA_orte_tmpdir_base=str(folder))  # apart from other tests' ranks
    for name in ('DISPLAY', 'WAYLAND_DISPLAY'):
        environment.pop(name, None)
    script = f'sluice() {{ {shlex.quote(program)} "$@"; }}\n{line}'
    return subprocess.run(['sh', '-c', script], cwd=folder, env=environment, capture_output=True, text=True, errors='replace')


def write_nifti(path):
    """24^3 bytes, bright inside a ball."""
    header = bytearray(352)
    struct.pack_into('<i', header, 0, 348)
    struct.pack_into('<8h', header, 40, 3, 24, 24, 24, 1, 1, 1, 1)
    struct.pack_into('<2h', header, 70, 2, 8)
    struct.pack_into('<8f', header, 76, 1, 1, 1, 1, 1, 1, 1, 1)
    struct.pack_into('<f', header, 108, 352)
    header[344:348] = b'n+1\0'
    voxels = bytes(min(255, max(0, 255 - 2 * ((x - 12)**2 + (y - 12)**2 + (z - 12)**2)))
                   for z in range(24) for y in range(24) for x in range(24))
    path.write_bytes(gzip.compress(bytes(header) + voxels))


def write_cells(path):
    """An OME-Zarr image of three channels of 24^3 voxels, a ball each."""
    (path / '0').mkdir(parents=True)
    axes = [{'name': 'c', 'type': 'channel'}] + [{'name': name, 'type': 'space'} for name in 'zyx']
    datasets = [{'path': '0', 'coordinateTransformations': [{'type': 'scale', 'scale': [1, 1, 1, 1]}]}]
    channels = [{'label': label, 'color': color, 'active': True, 'window': {'min': 0, 'max': 65535, 'start': 100, 'end': 900}}
                for label, color in (('DAPI', '00FFFF'), ('GFP', '00FF00'), ('RFP', 'FF00FF'))]
    attributes = {'multiscales': [{'version': '0.4', 'axes': axes, 'datasets': datasets}], 'omero': {'channels': channels}}
    array = {'zarr_format': 2, 'shape': [3, 24, 24, 24], 'chunks': [1, 24, 24, 24], 'dtype': '<u2', 'compressor': None,
             'fill_value': 0, 'order': 'C', 'filters': None, 'dimension_separator': '.'}
    (path / '.zgroup').write_text('{"zarr_format": 2}')
    (path / '.zattrs').write_text(json.dumps(attributes))
    (path / '0' / '.zarray').write_text(json.dumps(array))
    for channel in range(3):
        at = 8 + 4 * channel
        voxels = [max(0, 1000 - 20 * ((x - at)**2 + (y - 12)**2 + (z - 12)**2)) for z in range(24) for y in range(24) for x in range(24)]
        (path / '0' / f'{channel}.0.0.0').write_bytes(struct.pack(f'<{len(voxels)}H', *voxels))


def make_volumes(folder):
    """What the examples take for granted."""
    for name in ('bonsai', 'engine', 'scan', 'labels', 'ct'):
        write_nifti(folder / f'{name}.nii.gz')
    write_cells(folder / 'cells.ome.zarr')
    for line in ('sluice synth shells -q -o head.nrrd --dims 32,32,32',
                 'sluice synth shells -q -o pet.nrrd --dims 16,16,16',
                 'sluice synth phantom -q -o head_48x48x40_uint8.raw --dims 48,48,40',
                 'sluice synth phantom -q -o head_48x48x48_uint8.raw --dims 48,48,48',
                 'sluice synth mixing -q -o step_###.nrrd --dims 16,16,16 --steps 64',
                 'sluice render head.nrrd -q -o x.png --size 16 --report before.json',
                 'sluice render head.nrrd -q -o x.png --size 16 --report after.json'):
        made = run(folder, line)
        assert made.returncode == 0, made.stderr
    (folder / 'atlas.ctbl').write_text('1 one 255 0 0 255\n255 all 0 255 0 255\n')
    for name in ('skin', 'bone'):
        (folder / f'{name}.json').write_text(
            '{"sluice_transfer_function": 1, "map": "grey", "opacities": [[40, 0], [90, 0.5]]}')


def blocks_of(text):
    """The code blocks: (language, lines)."""
    block, language = [], None
    for line in text.splitlines() + ['']:
        if language is not None:
            if line.startswith('```'):
                yield language, block
                block, language = [], None
            else:
                block.append(line)
        elif line.startswith('```'):
            language, block = line[3:].strip(), []
        elif line.startswith('    ') and (block or line.strip()):
            block.append(line[4:])
        elif block:
            yield '', block
            block = []


def commands_of(page):
    text = page.read_text()
    for _, lines in blocks_of(text):
        for line in lines:
            line = line.split('  #')[0].strip()
            if re.match(r'(mpirun -n \d+ )?sluice ', line):
                yield line
    for code in re.findall(r'`(sluice [^`]*)`', text.replace('\n', ' ')):
        yield code


def examples_of_help(folder):
    """Those of the program and of each of its commands."""
    def helps(words):
        text = run(folder, ' '.join(['sluice', *words, '--help'])).stdout
        yield text
        if words == []:
            names = re.findall(r'^  ([a-z]+)  ', text, re.M)
        else:
            names = re.findall(r'^  ([a-z]+)  ', text, re.M) if words == ['bench'] else []
        for name in names:
            yield from helps([*words, name])
    for text in helps([]):
        yield from re.findall(r'^  (sluice .*)$', text, re.M)


def smaller(line):
    for large, small in SMALLER:
        line = re.sub(large, small, line)
    words = shlex.split(line)
    first = words.index('sluice')
    command = ' '.join(words[first + 1:first + 3])
    if words[first + 1] == 'render' and '--size' not in line:
        line += SIZE
    if command in ('bench render', 'bench algorithms', 'bench skipping', 'bench occlusion', 'bench quality') and '--frames' not in line:
        line += SIZE + ' --frames 1'
    if command in ('bench culling', 'bench threshold'):
        line += SIZE
    if command in ('bench channels', 'bench levels') and '--frames' not in line:
        line += ' --frames 1'
    return line


def runs(folder, line):
    """None, or what is wrong."""
    words = shlex.split(line)
    if '-o' in words:  # an example before it may have written the same
        made = folder / words[words.index('-o') + 1]
        shutil.rmtree(made) if made.is_dir() else made.unlink(missing_ok=True)
    if words[0] == 'mpirun' and shutil.which('mpirun') is None:
        return None
    if words[0] == 'mpirun':  # a shell's function is not a program
        line = line.replace(' sluice ', f' {shlex.quote(PROGRAM)} ', 1).replace('mpirun', 'mpirun --allow-run-as-root --oversubscribe', 1)
    if '.mp4' in line and shutil.which('ffmpeg') is None:
        (folder / 'bin').mkdir(exist_ok=True)
        (folder / 'bin' / 'ffmpeg').write_text('#!/bin/sh\ncat >/dev/null\n')
        (folder / 'bin' / 'ffmpeg').chmod(0o755)
        line = f'PATH="$PWD/bin:$PATH"; {line}'
    done = run(folder, line)
    if 'sluice view' in line:  # there is no display here, which it says
        return None if done.returncode == 1 and 'display' in done.stderr else f'{done.returncode}: {done.stderr}'
    return None if done.returncode == 0 else f'status {done.returncode}: {done.stderr.strip()}'


def json_examples(page):
    """The JSON texts of a page, from blocks that hold nothing else."""
    for language, lines in blocks_of(page.read_text()):
        text = '\n'.join(lines)
        if language == 'json' or text.lstrip().startswith('{'):
            yield text


def check_json(folder, text):
    """None, or what is wrong with an example as what it is for."""
    example = json.loads(text)
    if example.get('sluice') == 'view':
        example['volume']['paths'] = ['head.nrrd']
        example['crop'] = example.get('crop') and [0, 0, 0, 32, 32, 32]
        (folder / 'view.json').write_text(json.dumps(example))
        (folder / 'frame.json').write_text(json.dumps(example))
        return runs(folder, 'sluice render --state view.json -o of_view.png --size 32')
    if 'sluice_transfer_function' in example:
        (folder / 'example.json').write_text(text)
        return runs(folder, 'sluice render head.nrrd --transfer example.json -o of_transfer.png --size 32')
    if 'keys' in example:
        (folder / 'path.json').write_text(text)
        return runs(folder, 'sluice render head.nrrd --path path.json --frames 4 -o of_path.png --size 32')
    return 'no test knows what this example is for'


def main():
    complaints, count = [], 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_volumes(folder)
        for page in PAGES:
            for text in json_examples(page):
                count += 1
                fault = check_json(folder, text)
                if fault:
                    complaints.append(f'{page.relative_to(ROOT)}: {text[:60]}: {fault}')
        lines = [(page.relative_to(ROOT), line) for page in PAGES for line in commands_of(page)]
        lines += [('--help', line) for line in examples_of_help(folder)]
        seen = set()
        for place, line in lines:
            words = line.split()
            if PLACEHOLDER.search(line) or line in seen or not any(word.startswith('-') or '.' in word for word in words[2:]):
                continue
            seen.add(line)
            count += 1
            fault = runs(folder, smaller(line))
            if fault:
                complaints.append(f'{place}: {line}: {fault}')
    print('\n'.join(complaints) or f'{count} examples')
    assert count >= 30, f'only {count} examples were found'
    return 1 if complaints else 0


if __name__ == '__main__':
    sys.exit(main())

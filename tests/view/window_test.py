#!/usr/bin/env python3
"""A sitting with `sluice view` by real mouse and key events: open, turn, drag the threshold, edit a point, undo, slices, save;
what is saved is what `sluice render` draws with the command line that is printed."""
import importlib.util
import json
import os
import pathlib
import shlex
import subprocess
import sys

import window_driver
from window_driver import Display, Window

PROGRAM = sys.argv[1]


def pixels(path):
    import numpy
    import OpenImageIO
    image = OpenImageIO.ImageBuf(str(path))
    assert not image.has_error, f'{path}: {image.geterror()}'
    return numpy.asarray(image.get_pixels(OpenImageIO.UINT8)).astype(int)


def difference(a, b):
    a, b = pixels(a), pixels(b)
    assert a.shape == b.shape, f'{a.shape} and {b.shape}'
    assert a[..., 3].max() > 0, 'a picture of nothing'
    return abs(a - b).max()


def sitting(folder):
    volume = os.environ.get('SLUICE_VIEW_VOLUME', 'synth:shells,dims=64x56x48')
    with Display() as display, Window(display, PROGRAM, [volume, '--size', '480x760', '--device', 'cpu'], folder) as window:
        def step(name, act):
            mark = window.mark()
            act()
            picture = window.whole(mark)
            window.shot(name)
            return picture

        window.wait('opened')
        window.whole(0)
        window.shot('open')
        middle = window.place('picture')
        step('orbit', lambda: window.drag(middle, (middle[0] + 90, middle[1] + 35)))
        step('pan', lambda: window.drag(middle, (middle[0] + 20, middle[1] - 12), keys=['shift']))
        step('zoom', lambda: window.do('mousemove', *middle, 'click', 4, 'sleep', 0.05, 'click', 4))
        step('threshold', lambda: window.drag(window.place('threshold', 0.2), window.place('threshold', 0.35)))

        # A point more, dragged; undo takes both back, one after the other.
        saved = []

        def save(name):
            mark = window.mark()
            window.click('save view')
            window.wait(lambda line: line.get('saved', '').endswith('view.json'), since=mark)
            saved.append((name, json.loads(pathlib.Path(folder, 'view.json').read_text(encoding='utf-8'))))
            return saved[-1][1]

        before = save('before')
        assert before['look']['threshold'] > 0
        step('point added', lambda: window.click('transfer', x=0.8, y=0.3))
        added = save('added')
        assert len(added['look']['opacities']) == 4, added['look']
        step('point dragged', lambda: window.drag(window.place('transfer', 0.8, 0.3), window.place('transfer', 0.9, 0.5)))
        dragged = save('dragged')
        assert dragged['look']['opacities'] != added['look']['opacities']
        step('undone', lambda: window.key('ctrl+z'))
        assert save('undone')['look'] == added['look']
        step('undone twice', lambda: window.click('undo'))
        assert save('undone twice')['look'] == before['look']
        step('redone', lambda: window.click('redo'))
        assert save('redone')['look'] == added['look']
        step('point removed', lambda: window.click('transfer', button=3, x=0.8, y=0.3))
        assert len(save('removed')['look']['opacities']) == 3

        mark = window.mark()
        step('slices', lambda: window.click('slices'))
        for axis in range(3):
            window.wait(lambda line, axis=axis: line.get('slice') == axis, since=mark)
        mark = window.mark()
        window.click('slice 2', x=0.3, y=0.6)
        for axis in (0, 1):
            window.wait(lambda line, axis=axis: line.get('slice') == axis, since=mark)
        window.shot('cross hair')
        # A slice is read at its own voxels.
        window.do('mousemove', *window.place('slice 2', 0.6, 0.4))
        read = window.wait('slice_value', since=mark)
        cross = save('cross')['cross']
        assert read['voxel'][2] == cross[2], f'{read} at {cross}'
        assert cross != before['cross'] and cross[2] == before['cross'][2], cross
        step('no slices', lambda: window.key('v'))

        # A pointer that rests is told the value; a double click comes to the middle.
        mark = window.mark()
        window.do('mousemove', *window.place('picture', 0.5, 0.5))
        window.wait('value', since=mark)
        mark = window.mark()
        at = window.place('picture', 0.52, 0.47)
        window.do('mousemove', *at, 'sleep', 0.1, 'click', '--repeat', 2, '--delay', 60, 1)
        window.wait('centered', since=mark)
        window.whole(mark)
        step('perspective', lambda: window.key('p'))
        step('flown', lambda: window.key('w', 'e'))
        step('box', lambda: window.key('x'))
        step('mode', lambda: window.key('m'))
        step('composite', lambda: window.key('m', 'm', 'm'))
        step('black', lambda: window.key('b'))
        step('step', lambda: window.key('bracketright'))
        window.key('question')
        window.shot('keys')
        window.key('Escape')

        mark = window.mark()
        window.key('ctrl+s')
        command = window.wait(lambda line: line.get('saved', '').endswith('picture.png'), since=mark)['command']
        save('last')
        times = window.end()
        assert times['gl_errors'] == 0, times
        assert command in window.said()
    words = shlex.split(command)
    assert words[0] == 'sluice' and words[-2:] == ['-o', 'picture.png'], command
    environment = dict(os.environ, XDG_CACHE_HOME=f'{folder}/cache')
    again = [PROGRAM, *words[1:-1], 'again.png', '--device', 'cpu']
    subprocess.run(again, cwd=folder, check=True, env=environment, stdout=subprocess.DEVNULL)
    found = difference(f'{folder}/picture.png', f'{folder}/again.png')
    assert found <= 1, f'the printed command differs by {found}/255: {command}'
    # And from the saved view, which names its volume.
    size = words[words.index('--size') + 1]
    subprocess.run([PROGRAM, 'render', '--state', 'view.json', '--size', size, '-o', 'state.png', '--device', 'cpu'], cwd=folder,
                   check=True, env=environment, stdout=subprocess.DEVNULL)
    found = difference(f'{folder}/picture.png', f'{folder}/state.png')
    assert found <= 1, f'the saved view differs by {found}/255'
    print(f'{len(times)} numbers: {times}')


def faults(folder):
    """A bad file is said in the window, which stays; a machine without a display gets one line that names another way."""
    with Display() as display, Window(display, PROGRAM, ['nothing-there.nrrd'], folder) as window:
        line = window.wait('failure')['failure']
        assert 'nothing-there.nrrd' in line, line
        window.wait(lambda line: line.get('control') == 'failure')
        window.shot('bad file')
        window.wait(lambda line: line.get('control') == 'picture')
        window.end()
    with Display() as display:
        said = subprocess.run([PROGRAM, 'view', 'synth:shells,dims=20x20x20', '--log', '/dev/full'], capture_output=True, text=True,
                              env=dict(os.environ, DISPLAY=display.name, XDG_CONFIG_HOME=f'{folder}/config'), timeout=60, check=False)
    assert said.returncode == 1 and '/dev/full: the window\'s log cannot be written: No space' in said.stderr, said
    environment = {name: value for name, value in os.environ.items() if name not in ('DISPLAY', 'WAYLAND_DISPLAY')}
    environment['XDG_CONFIG_HOME'] = f'{folder}/config'
    said = subprocess.run([PROGRAM, 'view', 'synth:shells,dims=20x20x20'], env=environment, capture_output=True, text=True,
                          check=False)
    assert said.returncode == 1, said
    assert said.stderr.count('\n') == 1 and 'no display' in said.stderr and '`sluice render`' in said.stderr, said.stderr


if __name__ == '__main__':
    also_missing = [] if importlib.util.find_spec('OpenImageIO') else ['python3-openimageio']
    window_driver.run(sitting, faults, also_missing=also_missing)

#!/usr/bin/env python3
"""The rows of the window's panel for channels, a volume over another one and surfaces: what they change reaches the picture
and the saved view."""
import json
import pathlib
import subprocess
import sys

import window_driver
from window_driver import Display, Window

SCREEN = 960, 1000
SIZE = ['--size', '480x980', '--device', 'cpu']


def save(window, folder):
    mark = window.mark()
    window.click('save view')
    window.wait(lambda line: line.get('saved', '').endswith('view.json'), since=mark)
    return saved(folder)['look']


def saved(folder):
    return json.loads(pathlib.Path(folder, 'view.json').read_text(encoding='utf-8'))


def changed(window, change):
    mark = window.mark()
    change()
    window.whole(mark)


def slide(window, control, to):
    """Drags a slider to a part of its width."""
    window.drag(window.place(control, 0.5), window.place(control, to))


def pixel(window, place):
    """Red, green and blue there."""
    (x, y), (width, height) = place, SCREEN
    at = 4 * (y * width + x)
    return tuple(window.hand.pixels(width, height)[at:at + 3][::-1])


def channels(folder):
    import numpy
    import tifffile
    z, y, x = numpy.mgrid[:24, :32, :40]
    places = [(12, 10, 12), (12, 20, 26), (12, 16, 20)]
    stack = numpy.stack([(4000 * numpy.exp(-((z - c) ** 2 + (y - b) ** 2 + (x - a) ** 2) / 40)).astype('u2')
                         for c, b, a in places], axis=1)
    tifffile.imwrite(pathlib.Path(folder, 'cells.ome.tif'), stack, ome=True,
                     metadata={'axes': 'ZCYX', 'Channel': {'Name': ['DAPI', 'GFP', 'RFP']}})
    with Display(*SCREEN) as display, Window(display, sys.argv[1], ['cells.ome.tif', '--channel', '0,1,2', *SIZE],
                                               folder) as window:
        window.wait('opened')
        window.whole(0)
        window.place('channel 2 opacity')
        window.shot('channels')
        for channel, color in enumerate([(0, 255, 0), (255, 0, 255), (0, 255, 255)]):
            found = pixel(window, window.place(f'channel {channel} bar', 0.98))
            assert max(abs(a - b) for a, b in zip(found, color)) < 20, (channel, found)
        second, third = (window.place(f'channel {channel} bar') for channel in (1, 2))
        changed(window, lambda: window.click('channel 1 shows', x=0.1))
        assert {'channel': '1', 'opacity': 0} in looks(save(window, folder)), save(window, folder)
        assert window.place('channel 2 bar') == second != third, 'a channel that is hidden has a bar'
        window.shot('channels without one')
        changed(window, lambda: window.click('channel 1 shows', x=0.1))
        changed(window, lambda: slide(window, 'channel 0 opacity', 0.8))
        changed(window, lambda: window.drag(window.place('channel 2 range', 0.2), window.place('channel 2 range', 0.45)))
        own = {each['channel']: each for each in looks(save(window, folder))}
        assert own['1'].get('opacity', 1) > 0, own
        assert 0 < own['0']['opacity'] < 1, own
        assert own['2']['range'][0] > 0, own
        assert abs(own['2']['opacity'] - own['1']['opacity']) < 1e-6, own
        window.shot('channels changed')
        assert window.end()['gl_errors'] == 0


def over(folder):
    """The blended volume over the first one has a row, and the saved view both."""
    script = pathlib.Path(__file__).parent.parent / 'tools/over.py'
    subprocess.run([sys.executable, script, 'write'], cwd=folder, check=True)
    volumes = ['scan.nrrd', '--over', 'labels.nrrd']
    with Display(*SCREEN) as display, Window(display, sys.argv[1], [*volumes, *SIZE], folder) as window:
        window.wait('opened')
        window.whole(0)
        window.shot('labels over a scan')
        changed(window, lambda: window.click('channel over shows', x=0.1))
        look = save(window, folder)
        assert {'channel': 'over', 'opacity': 0} in looks(look), look
        assert 'combine' not in look, look
        assert saved(folder)['volume']['over'].endswith('labels.nrrd'), saved(folder)['volume']
        changed(window, lambda: window.click('channel over shows', x=0.1))
        changed(window, lambda: window.click('one medium', x=0.1))
        assert save(window, folder)['combine'] == 'add'
        changed(window, lambda: window.click('one medium', x=0.1))
        assert save(window, folder)['combine'] == 'blend'
        window.shot('labels over a scan again')
        assert window.end()['gl_errors'] == 0
    drawn = subprocess.run([sys.argv[1], 'render', '--state', 'view.json', '-o', 'state.png', '--size', '80x60'], cwd=folder,
                           capture_output=True, text=True, check=False)
    assert drawn.returncode == 0, drawn.stderr


def looks(look):
    """The texts of --look as values."""
    found = []
    for text in look['channels']:
        channel, _, rest = text.partition(':')
        parts = rest.split(',')
        one = {'channel': channel}
        if parts[0]:
            one['map'] = parts[0]
        for part in parts[1:]:
            if ':' in part:
                one['range'] = [float(value) for value in part.split(':')]
            else:
                one['opacity'] = float(part)
        found.append(one)
    return found


def surfaces(folder):
    with Display(*SCREEN) as display, Window(display, sys.argv[1], ['synth:shells,dims=48x48x48', *SIZE], folder) as window:
        window.wait('opened')
        window.whole(0)
        changed(window, lambda: window.click('add a surface'))
        window.shot('a surface')
        changed(window, lambda: slide(window, 'surface 0 value', 0.3))
        changed(window, lambda: slide(window, 'surface 0 opacity', 0.6))
        changed(window, lambda: window.click('add a surface'))
        one, other = save(window, folder)['surfaces']
        value, opacity = (float(part) for part in one.split(':')[:2])
        assert 40 < value < 110 and 0.3 < opacity < 0.9, one
        assert abs(float(other.split(':')[0]) - value) > 1, other
        window.shot('two surfaces')
        changed(window, lambda: window.click('remove surface 0'))
        assert save(window, folder)['surfaces'] == [other]
        assert window.end()['gl_errors'] == 0


if __name__ == '__main__':
    missing = []
    try:
        import tifffile  # noqa: F401
    except ImportError:
        missing = ['tifffile']
    window_driver.run(channels, over, surfaces, also_missing=missing)

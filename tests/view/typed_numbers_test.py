#!/usr/bin/env python3
"""Numbers that are typed into the window and cannot be drawn are refused there, so that a saved view can be read back; so are wrong
numbers of a view that is dropped, with a line that names file and field, after which the window goes on."""
import json
import pathlib
import sys

import dropping
import window_driver
from window_driver import Display, Window

VOLUME = 'synth:shells,dims=32x28x24'


def type_number(window, control, text):
    """Into a slider, as ImGui takes it: Ctrl and a click make it a field of text."""
    window.do('mousemove', *window.place(control, 0.3), 'keydown', 'ctrl', 'sleep', 0.1, 'mousedown', 1, 'sleep', 0.08, 'mouseup', 1,
              'keyup', 'ctrl', 'sleep', 0.2)
    window.press('ctrl+a')
    window.do('type', '--delay', 20, '--', text)  # it may begin with a minus
    window.press('Return')


def save(window, folder):
    mark = window.mark()
    window.click('save view')
    window.wait(lambda line: line.get('saved', '').endswith('view.json'), since=mark)
    window.shot('saved')
    return json.loads(pathlib.Path(folder, 'view.json').read_text(encoding='utf-8'))


def typed(folder):
    with Display() as display, Window(display, sys.argv[1], [VOLUME, '--size', '480x860', '--device', 'cpu'], folder) as window:
        window.wait('opened')
        window.whole(0)
        mark = window.mark()
        type_number(window, 'threshold', '40')
        window.whole(mark)
        assert save(window, folder)['look']['threshold'] == 40
        for text in ('-1e999', '1e999'):
            mark = window.mark()
            type_number(window, 'threshold', text)
            line = window.wait('failure', since=mark)['failure']
            assert '/look/threshold' in line and 'finite' in line, line
            window.wait(lambda line: line.get('control') == 'failure')
            window.shot(f'threshold {text}')
            window.press('Escape')
            window.press('Escape')
            window.do('sleep', 0.3)
        # The last number that could be drawn stays: ImGui gives each of those on the way there (1e9, 1e99).
        threshold = save(window, folder)['look']['threshold']
        assert isinstance(threshold, float) and abs(threshold) < 1e100, threshold
        mark = window.mark()
        window.click('load view')
        window.whole(mark)
        times = window.end()
        assert times['gl_errors'] == 0, times


def long_axis(folder):
    """An axis of more than 2^31 voxels, of which two chunks are stored."""
    voxels, chunk = 1 << 32, 4096
    store = pathlib.Path(folder, 'long.zarr')
    store.mkdir()
    (store / '.zarray').write_text(json.dumps({'zarr_format': 2, 'shape': [4, 4, voxels], 'chunks': [4, 4, chunk], 'dtype': '|u1',
                                               'compressor': None, 'fill_value': 0, 'order': 'C', 'filters': None}), encoding='utf-8')
    for number in (0, voxels // chunk - 1):
        (store / f'0.0.{number}').write_bytes(bytes([200]) * (16 * chunk))
    arguments = ['long.zarr', '--size', '480x860', '--device', 'cpu', '--threshold', '40', '--view', 'plain']
    with Display() as display, Window(display, sys.argv[1], arguments, folder) as window:
        window.wait('opened')
        window.whole(0)
        for section in ('look', 'opacity over values', 'view'):
            window.click(f'section {section}')
        window.click('section cut')
        mark = window.mark()
        type_number(window, 'crop x', '3000000000')
        window.whole(mark)
        crop = save(window, folder)['crop']
        assert crop == [3_000_000_000, 0, 0, voxels, 4, 4], crop
        window.end()


def dropped(folder):
    wrong = {'late': {'time': 5}, 'early': {'time': -1}, 'large': {'crop': [0, 0, 0, 32, 28, 25]},
             'key': {'path': {'kind': 'keys', 'keys': [{'time': 7, 'camera': {'eye': [0, 0, 90], 'target': [0, 0, 0]}}]}}}
    for name, state in wrong.items():
        pathlib.Path(folder, f'{name}.json').write_text(json.dumps({'sluice': 'view', **state}), encoding='utf-8')
        named = {'sluice': 'view', 'volume': {'paths': [VOLUME]}, **state}
        pathlib.Path(folder, f'{name} named.json').write_text(json.dumps(named), encoding='utf-8')
    with Display() as display, Window(display, sys.argv[1], [VOLUME, '--size', '480x760', '--device', 'cpu'], folder) as window:
        window.wait('opened')
        window.whole(0)
        identity = int(window.find('sluice'))
        for name in [*wrong, *(f'{name} named' for name in wrong)]:
            mark = window.mark()
            assert dropping.drop(display.name, identity, [pathlib.Path(folder, f'{name}.json')]), 'not taken'
            line = window.wait('failure', since=mark)['failure']
            assert f'{name}.json: expected' in line, line
            window.key('Escape')
        mark = window.mark()
        window.key('t')
        window.whole(mark)
        window.end()
    # The program's own option: the window stays, without a volume.
    arguments = [VOLUME, '--state', 'late.json', '--size', '480x760', '--device', 'cpu']
    with Display() as display, Window(display, sys.argv[1], arguments, folder) as window:
        line = window.wait('failure')['failure']
        assert 'late.json: expected a time step from 0 to 0 at /time, found 5' in line, line
        window.end()


if __name__ == '__main__':
    window_driver.run(typed, long_axis, dropped)

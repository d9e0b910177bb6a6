#!/usr/bin/env python3
"""`sluice view` plays a series: every step is shown whole, the next ones are read ahead, and the panel's button stops it."""
import os
import pathlib
import sys

import window_driver
from window_driver import Display, Window

STEPS = 5


def play(folder):
    arguments = [f'synth:mixing,dims=32x32x32,steps={STEPS}', '--size', '320x760', '--device', 'cpu']
    with Display() as display, Window(display, sys.argv[1], arguments, folder) as window:
        assert window.wait('opened')['time_steps'] == STEPS
        window.whole(0)
        mark = window.mark()
        window.click('play')
        for time in [*range(1, STEPS), 0]:
            window.wait(lambda line, time=time: line.get('complete') is True and line.get('time') == time, since=mark)
        window.key('space')
        window.settled()
        mark = window.mark()
        window.do('sleep', 0.6)
        window.update()
        assert not any('picture' in line for line in window.lines[mark:]), 'it plays on'
        window.key('period')
        window.whole(mark)
        mark = window.mark()
        window.drag(window.place('time', 0.1), window.place('time', 0.95))
        window.wait(lambda line: line.get('complete') is True and line.get('time') == STEPS - 1, since=mark)
        window.end()


def pane(window):
    """The pixels in the middle of the picture's pane."""
    x, y = window.place('picture')
    width, height = 800, 760
    window.echo()
    pixels = window.hand.pixels(width, height)
    return b''.join(pixels[4 * (row * width + x - 60):4 * (row * width + x + 60)] for row in range(y - 60, y + 60))


def fails(folder):
    """A step that cannot be read shows no other step's picture and value, and a series plays on behind it."""
    dims, name = 32, 's_%d_32x32x32_uint8.raw'
    for time in range(STEPS):
        row = bytes((x * 7 + time * 40) % 256 if 8 <= x < 24 else 0 for x in range(dims))
        pathlib.Path(folder, name % time).write_bytes(row * dims * dims)
    arguments = [str(pathlib.Path(folder, name)), '--size', '320x760', '--device', 'cpu']
    with Display() as display, Window(display, sys.argv[1], arguments, folder) as window:
        window.whole(0)
        window.key('period')
        window.settled()
        shown = pane(window)
        os.truncate(pathlib.Path(folder, name % 2), 1000)

        def fail(*keys):
            mark = window.mark()
            window.press(*keys)
            window.wait('failure', since=mark)
            window.press('Escape')
            window.do('sleep', 0.4)
            window.shot(f'failed {keys[0]}')
            found = pane(window)
            assert found == found[:4] * (len(found) // 4), f'{keys}: there is a picture'

        fail('period')
        window.press('comma')
        window.settled()
        assert pane(window) == shown, 'another picture of the step before'
        fail('period')  # the failure is known: there is no preview before it
        fail('Right')
        window.key('v')
        window.do('sleep', 0.4)
        window.shot('failed slices')
        mark = window.mark()
        window.click('play')
        for time in (3, 4, 0, 1):
            window.wait(lambda line, time=time: line.get('complete') is True and line.get('time') == time, since=mark)
        window.key('space')
        window.end()


if __name__ == '__main__':
    window_driver.run(play, fails)

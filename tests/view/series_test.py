#!/usr/bin/env python3
"""`sluice view` plays a series: every step is shown whole, the next ones are read ahead, and the panel's button stops it."""
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


if __name__ == '__main__':
    window_driver.run(play)

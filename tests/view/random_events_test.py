#!/usr/bin/env python3
"""10 000 random mouse and key events, or as many as a minute takes: memory is where it was, OpenGL has no error."""
import os
import random
import sys
import time

import window_driver
from window_driver import Display, Hand, Window

EVENTS = int(os.environ.get('SLUICE_RANDOM_EVENTS', '10000'))
SECONDS = float(os.environ.get('SLUICE_RANDOM_SECONDS', '60'))
# Nothing that saves, opens or ends.
KEYS = ['Left', 'Right', 'Up', 'Down', 'w', 's', 'a', 'd', 'q', 'e', 'p', 't', 'm', 'l', 'g', 'b', 'bracketleft', 'bracketright', 'x',
        'v', 'n', 'h', 'o', '0', '1', '2', '3', '4', '5', '6', 'ctrl+z', 'ctrl+y', 'question', 'Escape', 'plus', 'minus']


def anonymous_bytes(pid):
    with open(f'/proc/{pid}/status', encoding='utf-8') as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith('RssAnon'))


def batch(generator, hand, area):
    """Some events, slow enough for a window to see a drag as one; buttons are let go at the end. Left of x = 480 is the picture, where nothing saves."""
    held = None
    for number in range(40):
        if number % 4 == 3:
            hand.flush()
            time.sleep(0.004)
        what = generator.random()
        x, y = generator.randrange(area[0]), generator.randrange(area[1])
        if what < 0.75:
            hand.move(x, y)
        elif what < 0.85 and held is None:
            held = generator.choice([1, 1, 1, 2, 3])
            hand.move(x % 480, y)
            hand.button(held, True)
        elif what < 0.9 and held is not None:
            hand.button(held, False)
            held = None
        elif what < 0.94:
            for down in (True, False):
                hand.button(4 if what < 0.92 else 5, down)
        elif held is None:
            hand.move(x % 480, y)
            hand.key(generator.choice(KEYS))
    if held is not None:
        hand.button(held, False)
    hand.flush()


def storm(folder):
    generator = random.Random(1)
    arguments = ['synth:shells,dims=48x40x36', '--size', '480x420', '--device', 'cpu', '--memory', '64M']
    with Display() as display, Window(display, sys.argv[1], arguments, folder) as window:
        window.wait('opened')
        window.whole(0)

        hand = Hand(display)

        def play(events, seconds):
            until, before = time.monotonic() + seconds, hand.sent
            while hand.sent - before < events and time.monotonic() < until:
                batch(generator, hand, (800, 420))
                time.sleep(0.03)  # so that it is many turns of the loop
            return hand.sent - before

        # What is made once (fonts, drivers, levels of memory) is there after a fifth.
        done = play(EVENTS // 5, SECONDS / 4)
        window.do('sleep', 1)
        before = anonymous_bytes(window.process.pid)
        done += play(EVENTS - done, SECONDS)
        window.do('sleep', 1)
        after = anonymous_bytes(window.process.pid)
        window.key('Escape')
        times = window.end()
    print(f'{done} events sent, {times["events"]} taken, {times["wishes"]} wishes; memory {before >> 20} MiB, then {after >> 20} MiB')
    assert times['gl_errors'] == 0, times
    assert after - before < 24 << 20, f'{before} bytes became {after}'


if __name__ == '__main__':
    window_driver.run(storm)

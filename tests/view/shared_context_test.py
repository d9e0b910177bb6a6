#!/usr/bin/env python3
"""The GL device draws into textures of the window's own driver, with no read-back; what the window shows then is what it
shows of pictures that were read back, also in a mode that is read back in either case. It says why a picture is empty."""
import sys

import window_driver
from window_driver import Display, Hand, Window

WIDTH, HEIGHT = 320, 300
WORDS = 40  # rows at the top, where the value under a pointer that rested may be said
CLOSE = 3  # of 255 a channel: two drivers' arithmetic


def pictures(folder, *more):
    """Of the pane, after each of some steps; and the device's name."""
    arguments = ['synth:shells,dims=48x40x36', '--size', f'{WIDTH}x{HEIGHT}', '--device', 'gl', '--memory', '256M', *more]
    with Display() as display, Window(display, sys.argv[1], arguments, folder) as window:
        device = window.wait('opened')['device']
        window.whole(0)
        hand = Hand(display)
        found = []

        def step(act):
            act()
            hand.move(WIDTH + 200, 1)
            hand.flush()
            window.settled()
            found.append(hand.pixels(WIDTH, HEIGHT)[4 * WIDTH * WORDS:])

        window.key('o')  # nothing over the picture
        middle = window.place('picture')
        step(lambda: window.drag(middle, (middle[0] + 60, middle[1] + 25), steps=12))
        step(lambda: window.drag(window.place('threshold', 0.3), window.place('threshold', 0.5), steps=12))
        step(lambda: window.key('m'))
        step(lambda: window.key('b'))
        step(lambda: window.key('m', 'm', 'm'))
        times = window.end()
    assert times['gl_errors'] == 0, times
    return device, found


def same_pictures(folder):
    in_window, shared = pictures(folder)
    read_back, expected = pictures(folder, '--gl', 'osmesa')
    assert in_window.startswith('window, '), in_window
    assert not read_back.startswith('window, '), read_back
    for number, (a, b) in enumerate(zip(shared, expected)):
        largest = max(abs(x - y) for x, y in zip(a, b))
        print(f'step {number}: at most {largest}/255, {len(set(b))} values')
        assert len(set(b)) > 20, 'a picture of nothing'
        assert largest <= CLOSE, f'step {number} differs by {largest}/255'


def empty_pictures_say_why(folder):
    arguments = ['synth:shells,dims=48x40x36', '--size', f'{WIDTH}x{HEIGHT}', '--device', 'gl', '--memory', '256M']
    for more, reason in ([], ''), (['--threshold', '9999'], 'opacity 0'):
        with Display() as display, Window(display, sys.argv[1], arguments + more, folder) as window:
            assert window.wait('opened')['device'].startswith('window, ')
            why = window.whole(0)['why_empty']
            assert reason in why and bool(reason) == bool(why), why
            window.end()


if __name__ == '__main__':
    window_driver.run(same_pictures, empty_pictures_say_why)

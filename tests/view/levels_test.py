#!/usr/bin/env python3
"""A volume with levels of resolution in `sluice view`: whole from the first picture on, a finer picture fades in when the hand
rests, and nothing changes after the last one."""
import sys

import window_driver
from window_driver import Display, Hand, Window

WIDTH, HEIGHT = 480, 420


def covered(pixels):
    """Pixels of the pane that differ from its colour."""
    return sum(pixels[i:i + 3] != pixels[:3] for i in range(0, len(pixels), 4))


def coarse_first(folder):
    arguments = ['synth:shells,dims=200x190x180,levels=4', '--threshold', '90', '--size', f'{WIDTH}x{HEIGHT}', '--device', 'cpu',
                 '--memory', '256M']
    with Display(1000, 600) as display, Window(display, sys.argv[1], arguments, folder) as window:
        hand = Hand(display)
        first = window.wait('picture')
        assert first['levels'], first
        whole = window.whole(0)
        assert not whole['will_improve'], whole
        window.wait('faded_in')
        window.do('sleep', 0.5)
        window.shot('final')
        final = hand.pixels(WIDTH, HEIGHT)
        assert covered(final) > WIDTH * HEIGHT / 10, 'a picture of nothing'
        window.do('sleep', 0.4)
        assert hand.pixels(WIDTH, HEIGHT) == final, 'a final picture changes'
        # Every picture of a drag is whole.
        mark = window.mark()
        start, end = window.place('picture', 0.4), window.place('picture', 0.6)
        hand.move(*start)
        hand.flush()
        hand.button(1, True)
        for i in range(30):
            hand.move(start[0] + (end[0] - start[0]) * i // 30, start[1])
            hand.flush()
            window.do('sleep', 0.02)
            if i == 15:
                window.shot('moving')
                moving = hand.pixels(WIDTH, HEIGHT)
                assert abs(covered(moving) - covered(final)) < 0.2 * covered(final), (covered(moving), covered(final))
        released = window.mark()
        hand.button(1, False)
        hand.flush()
        previews = [line for line in window.lines[mark:released] if 'picture' in line]
        assert previews and all(line['levels'] for line in previews), previews
        window.whole(released)
        window.wait('faded_in', since=released)
        times = window.end()
        assert times['gl_errors'] == 0, times


if __name__ == '__main__':
    window_driver.run(coarse_first)

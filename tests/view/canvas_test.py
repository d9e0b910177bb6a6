#!/usr/bin/env python3
"""The window draws only what is another than in its last frame. After any events its pixels are those of a window that is
drawn anew, which it is when it gets another size."""
import random
import sys

import random_events_test
import window_driver
from window_driver import Display, Hand, Window

WIDTH, HEIGHT = 800, 420  # a pane of 480 beside the panel


def same_pixels(folder):
    generator = random.Random(4)
    arguments = ['synth:shells,dims=40x36x32', '--size', f'480x{HEIGHT}', '--device', 'cpu', '--memory', '64M']
    with Display(1000, 600) as display, Window(display, sys.argv[1], arguments, folder) as window:
        window.wait('opened')
        window.whole(0)
        hand = Hand(display)
        ids = window.find('sluice')

        def still():
            """When all events are taken, the newest picture is whole, and two looks, a moment apart, are the same: what pointers
            rest on is said."""
            window.settled()
            last = None
            for _ in range(40):
                window.do('sleep', 0.3)
                now = hand.pixels(WIDTH, HEIGHT)
                if now == last:
                    return now
                last = now
            raise AssertionError('the window does not come to rest')

        for round_number in range(8):
            random_events_test.batch(generator, hand, (WIDTH, HEIGHT))
            hand.move(20, 20)
            hand.flush()
            kept = still()
            assert len(set(kept)) > 8, 'a window of nothing'
            width, height = window.size(ids)
            window.do('windowsize', '--sync', ids, width + 40, height + 20)
            window.do('sleep', 0.3)
            window.do('windowsize', '--sync', ids, width, height)
            anew = still()
            different = sum(a != b for a, b in zip(kept, anew))
            assert different == 0, f'round {round_number}: {different} of {len(kept)} bytes differ'
        window.end()


if __name__ == '__main__':
    window_driver.run(same_pixels)

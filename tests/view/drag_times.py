#!/usr/bin/env python3
"""Measures, and tests nothing: drags the threshold in the real window by real events, 60 a second, and says how long it is from
the window's start to its first picture, from an event's sending to a picture on the screen that is no older, and from the button's
release to the whole one. With `view` in place of the threshold, it turns the volume.

  drag_times.py PROGRAM VOLUME [THRESHOLD [SECONDS [RUNS [ARGUMENT...]]]]

For speeds of a quiet machine where others work on it: `chrt -f 3` before it gives the X server and the window's own threads
the second priority of real time and those that draw the volume the first."""
import sys
import time

import window_driver
from window_driver import Display, Hand, Window


def spread(times):
    times = sorted(times)
    return {'n': len(times), **{name: round(1e3 * times[min(len(times) - 1, int(share * len(times)))], 1)
                                for name, share in (('p50', 0.5), ('p95', 0.95), ('max', 1))}}


def drag(folder):
    program, volume, threshold, seconds, runs, *more = sys.argv[1:] + ['40', '5', '1'][len(sys.argv) - 3:]
    turns = threshold == 'view'
    arguments = [volume, *([] if turns else ['--threshold', threshold]), '--size', '800x600', *more]
    for _ in range(int(runs)):
        started = time.monotonic()
        with Display() as display, Window(display, program, arguments, folder) as window:
            window.wait('opened')
            first = window.wait('picture')
            first_whole = window.whole(0)
            hand = Hand(display)
            window_driver.put_first(window.process, display)
            if turns:
                start, end = window.place('picture', 0.3), window.place('picture', 0.6)
            else:
                start, end = window.place('threshold', 0.2), window.place('threshold', 0.45)
            hand.move(*start)
            hand.flush()
            time.sleep(0.1)
            hand.button(1, True)
            hand.flush()
            time.sleep(0.2)
            sent, way, due = [], end[0] - start[0], time.monotonic()
            until = due + float(seconds)
            while due < until:
                at = len(sent) % (2 * way)
                # The window may see the event before flush() returns.
                sent.append(time.monotonic())
                hand.move(start[0] + (at if at < way else 2 * way - at), start[1])
                hand.flush()
                due += 1 / 60
                time.sleep(max(0, due - time.monotonic()))
            released, mark = time.monotonic(), window.mark()
            hand.button(1, False)
            hand.flush()
            whole = window.whole(mark)
            times = window.end()
        wishes = [(line['event_at'], line['wish']) for line in window.lines if 'wish' in line]
        pictures = [(line['at'], line['picture']) for line in window.lines if 'picture' in line]
        answers = []
        for at in sent:
            # The first wish of a turn that began after the event, and the first picture that is no older.
            wish = next((number for seen, number in wishes if seen >= at), None)
            shown = next((when for when, number in pictures if wish is not None and number >= wish), None)
            if shown is not None:
                answers.append(shown - at)
        shown = [line for line in window.lines if 'picture' in line and not line['complete']]
        print({'first_picture_ms': round(1e3 * (first['at'] - started)),
               'first_whole_ms': round(1e3 * (first_whole['at'] - started)),
               'levels': [line['levels'] for line in window.lines if 'picture' in line and line['complete']],
               'event_to_screen_ms': spread(answers), 'release_to_whole_ms': round(1e3 * (whole['at'] - released), 1),
               'whole_frame_ms': round(1e3 * whole['seconds'], 1), 'previews': len(shown),
               'pixels': sorted(line['size'][0] for line in shown)[len(shown) // 2],
               **{name: round(1e3 * times[f'{name}_seconds'], 1) for name in ('answer_p95', 'gl_p50', 'longest_turn')}})


if __name__ == '__main__':
    window_driver.run(drag)

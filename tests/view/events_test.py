#!/usr/bin/env python3
"""A window that is too busy to look at its events until all have come does what it does if it sees each as it comes: drags
begin and end where the button went down and up, along the same way, and no click and no key is lost."""
import contextlib
import json
import pathlib
import signal
import sys

import window_driver
from window_driver import Display, Window

PROGRAM = sys.argv[1]


def saved(window, folder):
    mark = window.mark()
    window.click('save view')
    window.wait(lambda line: line.get('saved', '').endswith('view.json'), since=mark)
    return json.loads(pathlib.Path(folder, 'view.json').read_text(encoding='utf-8'))


@contextlib.contextmanager
def stopped(window):
    """The window sees nothing meanwhile."""
    window.process.send_signal(signal.SIGSTOP)
    try:
        yield
    finally:
        window.process.send_signal(signal.SIGCONT)


def views(folder, is_busy):
    """The view after each of some gestures."""
    found = {}
    arguments = ['synth:shells,dims=48x40x36', '--size', '480x760', '--device', 'cpu', '--memory', '64M']
    with Display() as display, Window(display, PROGRAM, arguments, folder) as window:
        window.whole(0)
        window.stand_still()
        hand = window.hand

        def sent():
            hand.flush()
            if not is_busy:
                window.echo()

        def drag(*places, button=1):
            for number, place in enumerate(places):
                hand.move(*place)
                sent()
                if number == 0:
                    hand.button(button, True)
                    sent()
            hand.button(button, False)
            sent()
            hand.move(700, 20)  # what follows a drag is no part of it
            sent()

        def keys(*names):
            for name in names:
                window.press(name)
                sent()

        def gesture(name, act):
            window.echo()
            with stopped(window) if is_busy else contextlib.nullcontext():
                act()
            window.settled()
            found[name] = saved(window, folder)

        x, y = window.place('picture')
        low, middle, high = (window.place('threshold', part) for part in (0.2, 0.3, 0.6))
        box = window.place('slices')
        gesture('turn', lambda: drag((x, y), (x + 20, y), (x + 40, y + 20), (x + 40, y + 50)))
        gesture('move', lambda: drag((x, y), (x - 30, y + 4), (x - 31, y + 21), button=2))
        gesture('threshold', lambda: drag(low, middle, high))
        gesture('click', lambda: drag(box))
        gesture('two clicks', lambda: (drag(box), drag(box)))
        gesture('keys', lambda: keys('m', 'm', 'm', 'p', 'b', 'b', 'w', 'ctrl+z', 'e'))
        times = window.end()
    assert times['gl_errors'] == 0, times
    return found


def same_when_busy(folder):
    expected, busy = views(folder, False), views(folder, True)
    last = None
    for name, view in expected.items():
        if name != 'two clicks':
            assert view != last, f'{name}: nothing happened'
        assert busy[name] == view, f'{name}: {busy[name]} in place of {view}'
        last = view


def fitted_views(folder, gestures, is_busy):
    """The view that is saved at the end of each gesture."""
    found = []
    arguments = ['synth:shells,dims=48x40x36', '--size', '480x760', '--device', 'cpu', '--memory', '64M']
    with Display() as display, Window(display, PROGRAM, arguments, folder) as window:
        window.whole(0)
        window.stand_still()
        for gesture in gestures:
            mark = window.mark()
            with stopped(window) if is_busy else contextlib.nullcontext():
                for key in gesture:
                    window.press(key)
                    if not is_busy:
                        window.settled()
                        window.do('sleep', 0.7)  # steps of the history
                window.press('ctrl+shift+s')
                window.hand.flush()
            window.wait(lambda line: line.get('saved', '').endswith('view.json'), since=mark)
            view = json.loads(pathlib.Path(folder, 'view.json').read_text(encoding='utf-8'))
            found.append({part: view.get(part) for part in ('camera', 'clip')})
            found[-1]['keys'] = [key['camera'] for key in view.get('path', {}).get('keys', [])]
            window.settled()
        times = window.end()
    assert times['gl_errors'] == 0, times
    return found


def fitted(folder):
    """Views that are asked for by name are fitted on another thread. What is done meanwhile follows from the fitted view."""
    gestures = [['4'], ['5', 'Down', 'Down', 'Down'], ['t', '1', 'equal', 'w', 'e'], ['3', 'p', '6', 'Right'], ['2', 'Right', 'ctrl+z'],
                ['4', 'c'], ['1', 'k', 'Down']]
    expected, busy = (fitted_views(folder, gestures, is_busy) for is_busy in (False, True))
    for gesture, one, other in zip(gestures, expected, busy):
        assert one == other, f'{gesture}: {other} in place of {one}'


def unfitted(folder):
    """A save that waits for a view that cannot be fitted, or for which the window ends too early, is refused by name."""
    look = pathlib.Path(folder, 'look.json')
    points = '{"sluice_transfer_function": 1, "colors": [[0, "#00ff00"], [255, "#00ff40"]], "opacities": [[0, 0], [30, 0], [60, 0.1]]}'
    look.write_text(points, encoding='utf-8')
    arguments = ['synth:shells,dims=48x40x36', '--size', '480x760', '--device', 'cpu', '--transfer', str(look)]
    view = pathlib.Path(folder, 'view.json')
    with Display() as display, Window(display, PROGRAM, arguments, folder) as window:
        window.whole(0)
        mark = window.mark()
        look.unlink()
        window.key('m')  # reads the file again
        window.wait('failure', since=mark)
        mark = window.mark()
        with stopped(window):
            window.press('1', 'ctrl+shift+s')
        window.wait(lambda line: 'view.json' in line.get('failure', '') or 'view.json' in line.get('saved', ''), since=mark)
        assert not view.exists(), 'a view is saved that nobody asked for'
        window.press('Escape')
        look.write_text(points, encoding='utf-8')
        window.press('m')
        window.settled()
        with stopped(window):
            window.press('t', '1', 'ctrl+shift+s', 'ctrl+q')
        window.process.wait()
        assert view.exists() or 'view.json is not saved' in window.said(), window.said()
        print('the window ended', 'after' if view.exists() else 'before', 'the view was fitted')


if __name__ == '__main__':
    window_driver.run(same_when_busy, fitted, unfitted)

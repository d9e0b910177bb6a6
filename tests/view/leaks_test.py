#!/usr/bin/env python3
"""After random events the window ends without a leak: LeakSanitizer under the program as it is built for everybody."""
import pathlib
import random
import subprocess
import sys
import time

import random_events_test
import window_driver
from window_driver import Display, Hand, Window

BATCHES = 60
# Libraries that would go with the window, and with them the addresses of what they keep for good: they stay.
KEPT = ['libGL.so.1', 'libGLX_mesa.so.0', 'libglfw.so.3', 'libXcursor.so.1', *map(str, pathlib.Path('/usr/lib').glob('*/dri/swrast_dri.so'))]


def sanitizer():
    """The library, where there is a compiler that has one; else None."""
    try:
        said = subprocess.run(['gcc', '-print-file-name=liblsan.so'], capture_output=True, text=True, check=True).stdout.strip()
    except OSError:
        return None
    return said if pathlib.Path(said).is_absolute() else None


def sit(folder, *libraries):
    arguments = ['synth:shells,dims=48x40x36', '--size', '480x420', '--device', 'cpu', '--memory', '64M']
    under = {'LD_PRELOAD': ' '.join([sanitizer(), *libraries, *KEPT]), 'LSAN_OPTIONS': 'exitcode=23'}
    with Display() as display, Window(display, sys.argv[1], arguments, folder, under) as window:
        window.wait('opened')
        window.whole(0)
        hand, generator = Hand(display), random.Random(2)
        for _ in range(BATCHES):
            random_events_test.batch(generator, hand, (800, 420))
            time.sleep(0.03)
        window.key('Escape', 'Escape')
        try:
            window.end()
        except RuntimeError as error:
            return str(error)
    return ''


def ends_clean(folder):
    said = sit(folder)
    assert not said, said
    lost = sit(folder, sys.argv[3])
    assert 'leaked in' in lost, f'a library that loses memory is not seen: {lost[-500:]}'


if __name__ == '__main__':
    window_driver.run(ends_clean, also_missing=[] if sanitizer() else ['liblsan.so (of gcc)'])

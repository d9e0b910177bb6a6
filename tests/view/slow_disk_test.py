#!/usr/bin/env python3
"""A volume 20 times the budget on a disk of 50 MB a second: the window turns, drags and ends while its blocks are read, and
says that the picture is not whole. How long its loop took is printed; SLUICE_STALL_MS makes it a bound (machines with other
work on them stall anybody)."""
import os
import pathlib
import subprocess
import sys
import time

import window_driver
from window_driver import Display, Window

PROGRAM, SLOW_DISK = sys.argv[1:3]
BUDGET = '24M'


def sit(folder):
    volume = pathlib.Path(folder, 'large.nrrd')
    environment = dict(os.environ, XDG_CACHE_HOME=f'{folder}/cache')
    # 480 MiB; its index is made before the disk is slow.
    subprocess.run([PROGRAM, 'synth', 'shells', '--dims', '800,800,786', '-o', volume], check=True, env=environment, stdout=subprocess.DEVNULL)
    subprocess.run([PROGRAM, 'info', volume], check=True, env=environment, stdout=subprocess.DEVNULL)
    slow = {'LD_PRELOAD': SLOW_DISK, 'SLUICE_SLOW_FILE': 'large.', 'SLUICE_SLOW_BYTES_PER_SECOND': '50e6'}
    arguments = [str(volume), '--size', '480x400', '--device', 'cpu', '--memory', BUDGET]
    with Display() as display, Window(display, PROGRAM, arguments, folder, slow) as window:
        window.wait('opened')
        window.wait('picture')
        window_driver.put_first(window.process, display)
        middle = window.place('picture')
        until = time.monotonic() + 12
        side = 1
        while time.monotonic() < until:
            window.drag(middle, (middle[0] + 60 * side, middle[1]), steps=40)
            window.drag(window.place('threshold', 0.3), window.place('threshold', 0.4 + 0.1 * side), steps=40)
            side = -side
        pictures = [line for line in window.lines if 'picture' in line]
        window.update()
        times = window.end()
    answered = times['answers']
    print({name: times[name] for name in sorted(times)})
    for line in window.lines:
        if 'long_turn_seconds' in line:
            print({name: round(1e3 * value, 1) if name.endswith('seconds') else value for name, value in line.items()})
    assert answered > 20, f'{answered} events had an answer'
    assert not all(line['complete'] for line in pictures), 'a disk so slow has previews'
    bound = os.environ.get('SLUICE_STALL_MS')
    if bound:
        assert times['longest_turn_seconds'] * 1e3 <= float(bound), times


if __name__ == '__main__':
    window_driver.run(sit, scratch_in='/var/tmp')

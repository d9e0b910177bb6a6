#!/usr/bin/env python3
"""Errors of OpenGL that a window makes are counted and said: a library that makes some is put under it."""
import sys

import window_driver
from window_driver import Display, Window


def errors(folder, more):
    with Display() as display, Window(display, sys.argv[1], ['synth:shells,dims=24x24x24', '--size', '300x300', '--device', 'cpu'],
                                      folder, more) as window:
        window.wait('opened')
        window.whole(0)
        window.key('question', 'Escape')
        return window.end(), [line['gl_message'] for line in window.lines if 'gl_message' in line]


def seen(folder):
    times, messages = errors(folder, {'LD_PRELOAD': sys.argv[3]})
    print(times['gl_errors'], messages[:1])
    assert times['gl_errors'] > 1, 'glGetError was not heard'
    assert messages, 'GL_KHR_debug was not heard'
    times, messages = errors(folder, {})
    assert times['gl_errors'] == 0 and not messages, (times, messages)


if __name__ == '__main__':
    window_driver.run(seen)

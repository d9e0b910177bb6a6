#!/usr/bin/env python3
"""Files come to the window by its dialog, by a drop, and from the list of recent ones; what cannot be opened gives its message there,
and a slow disk stalls nothing."""
import json
import os
import pathlib
import shutil
import subprocess
import sys

import dropping
import window_driver
from window_driver import Display, Window

PROGRAM, SLOW_DISK = sys.argv[1:3]
ODD = "it's 100% \u00e9t\u00e9 \"quoted\".nrrd"


def synth(path, kind='shells', dims='24x20x16'):
    plain = path.with_name('plain.nrrd')  # a % in a name that is written is a place for numbers
    subprocess.run([PROGRAM, 'synth', kind, '--dims', dims, '-o', str(plain), '-q'], check=True, stdout=subprocess.DEVNULL)
    plain.rename(path)


def opened(window, mark, end):
    line = window.wait('opened', since=mark)
    assert line['opened'].endswith(end), line
    window.whole(mark)
    return line


def ask_for_file(window):
    """The dialog, once it stands still. A mark after its folder was listed."""
    mark = window.mark()
    window.key('ctrl+o')
    window.wait('folder', since=mark)
    window.stand_still()
    return window.mark()


def dialog(folder):
    """By keys and by the mouse: into a folder, up again, a series as one entry, odd names, what cannot be read."""
    data = pathlib.Path(folder, 'data & more')
    (data / 'inner').mkdir(parents=True)
    synth(data / ODD)
    for i in (1, 2, 3):
        synth(data / f'step_{i:03}.nrrd')
    (data / 'broken.nrrd').write_bytes(b'NRRD0004\ntype: no such\n\n')
    (data / 'notes.txt').write_text('no volume')
    with Display() as display, Window(display, PROGRAM, ['--size', '640x700', '--device', 'cpu'], folder) as window:
        # Without a volume it asks for one, from the folder that it was started in.
        line = window.wait('folder')
        assert line['folder'] == os.path.realpath(folder) or line['folder'] == folder, line
        window.stand_still()
        mark = window.mark()
        window.do('type', '--delay', 12, 'data')
        window.press('Down', 'Return')
        line = window.wait('folder', since=mark)
        assert line['folder'].endswith('data & more') and line['entries'] == 4, line
        window.stand_still()
        window.shot('dialog')
        mark = window.mark()
        window.click('entry step_%03d.nrrd')
        assert opened(window, mark, 'step_%03d.nrrd')['time_steps'] == 3
        assert not any('notes' in name for name in window.controls), window.controls
        # One of its steps alone; it begins where it was.
        ask_for_file(window)
        window.click('series as one')
        mark = window.mark()
        window.click('entry step_002.nrrd')
        assert opened(window, mark, 'step_002.nrrd')['time_steps'] == 1
        mark = ask_for_file(window)
        window.do('type', '--delay', 12, '100%')
        window.press('Return')  # the one that is left
        opened(window, mark, ODD)
        # Backspace leads up, Down and Return into a folder, a path that is typed anywhere.
        mark = ask_for_file(window)
        window.press('BackSpace')
        assert window.wait('folder', since=mark)['folder'] == str(pathlib.Path(line['folder']).parent)
        window.do('sleep', 0.2, 'type', '--delay', 12, f'{data}/broken.nrrd')
        mark = window.mark()
        window.press('Return')
        failure = window.wait('failure', since=mark)['failure']
        assert 'broken.nrrd' in failure, failure
        window.shot('bad file of the dialog')
        window.press('Escape')
        window.end()


def unreadable(folder):
    """A folder that went meanwhile gives its message; the dialog goes on."""
    inner = pathlib.Path(folder, 'goes')
    inner.mkdir()
    with Display() as display, Window(display, PROGRAM, ['--size', '640x700', '--device', 'cpu'], folder) as window:
        window.wait('folder')
        window.stand_still()
        at = window.place('entry goes')
        inner.rmdir()
        mark = window.mark()
        window.do('mousemove', *at, 'sleep', 0.1, 'mousedown', 1, 'sleep', 0.05, 'mouseup', 1)
        line = window.wait(lambda line: line.get('folder', '').endswith('goes'), since=mark)
        assert 'No such file' in line['failure'], line
        window.stand_still()
        window.shot('unreadable folder')
        mark = window.mark()
        window.click('up')
        assert not window.wait('folder', since=mark)['failure']
        window.end()


def slow_folder(folder):
    """While a folder takes seconds to list, the window turns."""
    slow = pathlib.Path(folder, 'tarry')
    slow.mkdir()
    for name in 'abcd':
        (slow / f'{name}.nrrd').write_text('x')
    environment = {'LD_PRELOAD': SLOW_DISK, 'SLUICE_SLOW_FOLDER': 'tarry'}
    with Display() as display, Window(display, PROGRAM, ['--size', '640x700', '--device', 'cpu'], folder, environment) as window:
        window.wait('folder')
        window.stand_still()
        mark = window.mark()
        window.click('entry tarry')
        window.do('sleep', 1)
        window.shot('slow folder')
        window.update()
        assert not any('folder' in line for line in window.lines[mark:]), 'the folder was not slow'
        window.click('up')  # not waited for
        line = window.wait('folder', since=mark)
        assert line['folder'].endswith(pathlib.Path(folder).name), line
        times = window.end()
        assert times['longest_turn_seconds'] < 0.5, times


def recent_and_drops(folder):
    """Dropped files are opened and kept in the list; one that vanished says so and leaves it; a bad one says so."""
    for name in ('a.nrrd', ODD, 'steps 1.nrrd', 'steps 2.nrrd'):
        synth(pathlib.Path(folder, name))
    pathlib.Path(folder, 'bad.nrrd').write_text('nothing')
    settings = pathlib.Path(folder, 'config/sluice/view.json')
    with Display() as display, Window(display, PROGRAM, ['a.nrrd', '--size', '640x700', '--device', 'cpu'], folder) as window:
        window.wait('opened')
        window.whole(0)
        identity = int(subprocess.run(['xdotool', 'search', '--name', '^sluice$'], env=window.environment, check=True, capture_output=True,
                                      text=True).stdout.split()[-1])

        def drop(*names):
            mark = window.mark()
            assert dropping.drop(display.name, identity, [pathlib.Path(folder, name) for name in names]), 'not taken'
            return mark

        opened(window, drop(ODD), ODD)
        line = opened(window, drop('steps 1.nrrd', 'steps 2.nrrd'), 'steps 1.nrrd')
        assert line['time_steps'] == 2, line
        mark = drop('bad.nrrd')
        line = window.wait('failure', since=mark)['failure']
        assert 'bad.nrrd' in line, line
        window.wait(lambda line: line.get('control') == 'failure')
        window.shot('bad drop')
        window.key('Escape')
        # What was open before stays.
        window.key('t')
        window.whole(mark)
        # The newest first, as absolute names.
        window.wait(lambda line: settings.exists())
        recent = json.loads(settings.read_text(encoding='utf-8'))['recent']
        assert [pathlib.Path(path).name for path in recent] == [ODD, 'a.nrrd'] and all(os.path.isabs(path) for path in recent), recent
        pathlib.Path(folder, ODD).unlink()
        mark = ask_for_file(window)
        window.shot('recent')
        window.click('recent 1')
        opened(window, mark, 'a.nrrd')
        mark = ask_for_file(window)
        window.click('recent 1')
        assert ODD in window.wait('vanished', since=mark)['vanished']
        assert ODD in window.wait('failure', since=mark)['failure']
        window.shot('vanished')
        window.press('Escape')
        window.end()
    recent = json.loads(settings.read_text(encoding='utf-8'))['recent']
    assert [pathlib.Path(path).name for path in recent] == ['a.nrrd'], recent
    # A name that a shell started elsewhere finds too.
    other = pathlib.Path(folder, 'elsewhere')
    other.mkdir()
    shutil.copytree(f'{folder}/config', other / 'config')
    with Display() as display, Window(display, PROGRAM, ['--size', '640x700', '--device', 'cpu'], other) as window:
        window.wait('folder')
        window.stand_still()
        mark = window.mark()
        window.click('recent 0')
        opened(window, mark, 'a.nrrd')
        window.end()


def not_as_the_file_says(folder):
    """A volume that its path alone would open in another way is not kept in the list."""
    synth(pathlib.Path(folder, 'a.nrrd'))
    with Display() as display, Window(display, PROGRAM, ['a.nrrd', '--spacing', '1,1,3', '--size', '640x700', '--device', 'cpu'], folder) as window:
        window.wait('opened')
        window.whole(0)
        window.end()
    settings = pathlib.Path(folder, 'config/sluice/view.json')
    recent = json.loads(settings.read_text(encoding='utf-8'))['recent'] if settings.exists() else []
    assert recent == [], recent


if __name__ == '__main__':
    window_driver.run(dialog, unreadable, slow_folder, recent_and_drops, not_as_the_file_says)

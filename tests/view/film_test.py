#!/usr/bin/env python3
"""A film from the window: key frames and a turntable, previewed, written as frames while the window goes on, cancelled; the printed
command writes the same frames. Pictures saved as EXR are `sluice render`'s."""
import importlib.util
import json
import os
import pathlib
import shlex
import signal
import subprocess
import sys

import window_driver
from window_driver import Display, Window

PROGRAM = sys.argv[1]
VOLUME = 'synth:shells,dims=48x40x36'


def values(path):
    """As they are in the file now: OpenImageIO's buffers keep what they once read under a name."""
    import OpenImageIO
    image = OpenImageIO.ImageInput.open(str(path))
    assert image, f'{path}: {OpenImageIO.geterror()}; {os.stat(path)}'
    pixels = image.read_image(OpenImageIO.FLOAT)
    image.close()
    return pixels


def seen(path):
    """Of a PNG with straight alpha what is seen: the colour of a pixel that rounding makes just transparent is none."""
    pixels = values(path)
    if str(path).endswith('.png'):
        pixels[..., :3] *= pixels[..., 3:4]
    return pixels


def difference(a, b):
    import numpy
    a, b = seen(a), seen(b)
    assert a.shape == b.shape, f'{a.shape} and {b.shape}'
    assert a[..., 3].max() > 0, 'a picture of nothing'
    both = numpy.isfinite(a) & numpy.isfinite(b)  # depth where nothing is
    assert (numpy.isfinite(a) == numpy.isfinite(b)).all()
    return abs(numpy.where(both, a, 0) - numpy.where(both, b, 0)).max()


def render(command, folder, output):
    """The printed command with its pictures elsewhere."""
    words = shlex.split(command)
    assert words[:2] == ['sluice', 'render'] and words[-2] == '-o', command
    subprocess.run([PROGRAM, *words[1:-1], output, '--device', 'cpu'], cwd=folder, check=True, stdout=subprocess.DEVNULL,
                   env=dict(os.environ, XDG_CACHE_HOME=f'{folder}/cache'))


def saved(window, mark, end):
    """The command of what was saved; once the panel has settled, in which a line comes and the progress goes."""
    command = window.wait(lambda line: line.get('saved', '').endswith(end), since=mark)['command']
    window.do('sleep', 0.5)
    return command


def open_film(window):
    """Other sections make room for it."""
    for section in ('look', 'opacity over values', 'view'):
        window.click(f'section {section}')
    window.click('section film')
    window.place('turntable')
    window.do('sleep', 0.2)


def key_frames(folder):
    with Display() as display, Window(display, PROGRAM, [VOLUME, '--size', '320x760', '--device', 'cpu'], folder) as window:
        window.wait('opened')
        window.whole(0)
        mark = window.mark()
        middle = window.place('picture')
        window.drag(window.place('threshold', 0.2), window.place('threshold', 0.3))
        window.whole(mark)
        window.key('k')
        mark = window.mark()
        window.drag(middle, (middle[0] + 120, middle[1] + 30))
        window.drag(window.place('threshold', 0.3), window.place('threshold', 0.5))
        window.whole(mark)
        window.key('k')
        mark = window.mark()
        window.do('mousemove', *middle, 'click', 4, 'sleep', 0.05, 'click', 4)
        window.whole(mark)
        window.key('k')
        assert window.wait(lambda line: line.get('keys') == 3)
        open_film(window)
        # Seconds by a drag: short ones, so that the film is.
        for i in range(2):
            window.drag(window.place(f'seconds {i}', 0.5), (window.place(f'seconds {i}', 0.5)[0] - 32, window.place(f'seconds {i}')[1]))
        mark = window.mark()
        window.click('play film')
        window.do('sleep', 0.3)
        window.shot('film plays')
        window.wait(lambda line: line.get('film') == 'ended', since=mark)
        previews = [line for line in window.lines[mark:] if 'picture' in line]
        assert len(previews) >= 3, f'{len(previews)} pictures of a film'
        mark = window.mark()
        window.drag(window.place('frame', 0.1), window.place('frame', 0.6))
        window.whole(mark)
        window.shot('film frame')
        window.click('back')
        window.click('frame rate', x=0.1)
        mark = window.mark()
        window.fill('film name', "it's 50p %03d.png")
        window.click('write frames')
        command = saved(window, mark, '%03d.png')
        # The same path is in a saved view.
        mark = window.mark()
        window.click('save view')
        saved(window, mark, 'view.json')
        path = json.loads(pathlib.Path(folder, 'view.json').read_text(encoding='utf-8'))['path']
        assert path['kind'] == 'keys' and len(path['keys']) == 3, path
        assert path['keys'][0]['look']['threshold'] < path['keys'][1]['look']['threshold']
        mark = window.mark()
        window.fill('picture name', 'deep.exr')
        window.click('save picture')
        exr = saved(window, mark, 'deep.exr')
        times = window.end()
        assert times['gl_errors'] == 0, times
        assert command in window.said()
    frames = sorted(pathlib.Path(folder).glob("it's 50p *.png"))
    assert len(frames) >= 3, frames
    assert not list(pathlib.Path(folder).glob('*.tmp'))
    render(command, folder, 'again_%03d.png')
    again = sorted(pathlib.Path(folder).glob('again_*.png'))
    assert len(again) == len(frames), (frames, again)
    most = [difference(a, b) * 255 for a, b in zip(frames, again)]
    assert max(most) <= 1.001, f'{command}: frames differ by {most}/255'
    assert difference(frames[0], frames[-1]) > 0.05, 'a film in which nothing moves'
    render(exr, folder, 'again.exr')
    found = difference(f'{folder}/deep.exr', f'{folder}/again.exr')
    assert values(f'{folder}/deep.exr').shape[2] == 5, 'no depth'
    # Of colours; depths of 100 are single numbers.
    assert found <= 1.001 / 255, f'{exr} differs by {found}'
    # A name without a number is the view itself.
    subprocess.run([PROGRAM, 'render', '--state', 'view.json', '--size', '64x64', '-o', 'one.png', '--device', 'cpu'], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    assert pathlib.Path(folder, 'one.png').exists()
    print(f'{len(frames)} frames, differing by {max(most):.2f}/255; EXR by {255 * found:.3f}/255')


def taken_and_removed(folder):
    """A key frame that takes a view while it is fitted is the one of the row, also if another is removed meanwhile."""
    with Display() as display, Window(display, PROGRAM, [VOLUME, '--size', '320x760', '--device', 'cpu'], folder) as window:
        window.whole(0)
        for key in ('k', 'Right', 'k', 'Right', 'k'):
            window.key(key)
            window.settled()
        open_film(window)
        places = [window.place('take key 2'), window.place('remove key 0')]
        window.process.send_signal(signal.SIGSTOP)
        window.press('t', '1')
        for place in places:
            window.hand.move(*place)
            window.hand.button(1, True)
            window.hand.button(1, False)
        window.hand.flush()
        window.process.send_signal(signal.SIGCONT)
        window.settled()
        mark = window.mark()
        window.click('save view')
        saved(window, mark, 'view.json')
        window.end()
    view = json.loads(pathlib.Path(folder, 'view.json').read_text(encoding='utf-8'))
    cameras = [key['camera'] for key in view['path']['keys']]
    assert len(cameras) == 2 and cameras[1] == view['camera'] != cameras[0], view


def turntable(folder):
    """Cancelled halfway; then, in a folder that cannot be written, a line in the window; never over what is read."""
    volume = pathlib.Path(folder, 'shells_0001.nrrd')
    subprocess.run([PROGRAM, 'synth', 'shells', '--dims', '64x56x48', '-o', str(volume)], check=True, stdout=subprocess.DEVNULL)
    with Display() as display, Window(display, PROGRAM, [str(volume), '--size', '320x760', '--device', 'cpu'], folder) as window:
        window.wait('opened')
        window.whole(0)
        open_film(window)
        window.click('turntable')
        mark = window.mark()
        window.click('write frames')
        window.wait(lambda line: line.get('written', 0) >= 3, since=mark)
        # The hand goes first while frames are written.
        middle = window.place('picture')
        window.drag(middle, (middle[0] + 60, middle[1]))
        window.whole(mark)
        window.shot('film written')
        window.click('write frames')  # says cancel
        window.do('sleep', 0.5)
        count = len(list(pathlib.Path(folder).glob('frame_*.png')))
        assert 3 <= count < 90, count
        window.do('sleep', 0.5)
        assert len(list(pathlib.Path(folder).glob('frame_*.png'))) == count, 'it goes on'
        assert not list(pathlib.Path(folder).glob('*.tmp'))

        def refused(field, name, button, words):
            mark = window.mark()
            window.fill(field, name)
            window.click(button)
            line = window.wait('failure', since=mark)['failure']
            assert all(word in line for word in words), line
            window.wait(lambda line: line.get('control') == 'failure')
            window.shot(f'{button} refused')
            window.key('Escape')

        refused('film name', 'frame.png', 'write frames', ['frame.png', 'frame_%04d.png'])
        refused('film name', 'frame_%04d.jpg', 'write frames', ['.png or .exr'])
        refused('film name', 'no such folder/f_%04d.png', 'write frames', ['no such folder'])
        before = volume.read_bytes()
        refused('picture name', str(volume), 'save picture', ['.png or .exr'])
        refused('state name', str(volume), 'save view', ['reads'])
        window.end()
        assert volume.read_bytes() == before


def same_looks(folder):
    """Points over a file's colours keep them, and a step of a lit series that spans less than the others: the command gives the same."""
    import numpy
    grid = numpy.mgrid[:36, :40, :44].astype(float)
    away = numpy.sqrt(sum(((axis - (size - 1) / 2) / size) ** 2 for axis, size in zip(grid, grid.shape[1:])))
    for step, top in enumerate((250, 60)):
        voxels = (top * numpy.clip(1.1 - 2 * away, 0, 1)).astype(numpy.uint8)
        header = 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 44 40 36\nencoding: raw\n\n'
        pathlib.Path(folder, f'ball {step}.nrrd').write_bytes(header.encode() + voxels.tobytes())
    colours = {'sluice_transfer_function': 1, 'colors': [[0, '#00ff00'], [255, '#00ff40']], 'opacities': [[0, 0], [30, 0], [60, 0.1]]}
    pathlib.Path(folder, "it's green.json").write_text(json.dumps(colours))
    arguments = ['ball %d.nrrd', '--threshold', '20', '--size', '400x760', '--device', 'cpu', '--time', '1']
    with Display() as display, Window(display, PROGRAM, arguments, folder) as window:
        window.wait('opened')
        window.whole(0)
        commands = []

        def save(name):
            mark = window.mark()
            window.fill('picture name', name)
            window.click('save picture')
            commands.append((name, saved(window, mark, name)))

        for section in ('time', 'view'):  # room for the files
            window.click(f'section {section}')
        # A range for the colours and the ramp, as the slider gives it.
        mark = window.mark()
        window.drag(window.place('threshold', 0.08), window.place('threshold', 0.1))
        window.whole(mark)
        save('lit.png')
        mark = window.mark()
        window.fill('transfer name', "it's green.json")
        window.click('load transfer')
        window.whole(mark)
        mark = window.mark()
        window.click('transfer', x=0.15, y=0.2)
        window.whole(mark)
        window.shot('points over a file')
        save('green.png')
        window.end()
    for name, command in commands:
        render(command, folder, f'again {name}')
        found = 255 * difference(f'{folder}/{name}', f'{folder}/again {name}')
        assert found <= 1.001, f'{command} differs by {found}/255'
        print(f'{name}: {found:.2f}/255')
    assert '--transfer ' in commands[1][1] and '--opacities ' in commands[1][1], commands[1]
    green = values(f'{folder}/green.png')
    assert green[..., 1].max() > 0.2 and green[..., 0].max() < 0.05, 'the colours of the file are gone'


if __name__ == '__main__':
    also_missing = [] if importlib.util.find_spec('OpenImageIO') else ['python3-openimageio']
    window_driver.run(key_frames, taken_and_removed, turntable, same_looks, also_missing=also_missing)

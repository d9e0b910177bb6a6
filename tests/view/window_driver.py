"""Drives `sluice view` by real mouse and key events: an X server without a screen (Xvfb), xdotool, and the window's log."""
import ctypes
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

NEEDED = ('Xvfb', 'xdotool')
# Between two lines that say what a test waits for.
TELL_SECONDS = 60


def missing():
    """Programs that are not installed."""
    return [name for name in NEEDED if shutil.which(name) is None]


def run(*tests, also_missing=(), scratch_in=None):
    """Each test with a folder of its own; exit status 77, and what is missing by name, where they cannot run."""
    absent = missing() + list(also_missing)
    if absent:
        print('missing: ' + ', '.join(absent))
        sys.exit(77)
    for test in tests:
        with tempfile.TemporaryDirectory(dir=scratch_in) as scratch:
            test(scratch)


def put_first(process, display):
    """Where this runs with a priority of real time: the X server and the window's own threads before those that draw the volume,
    and all of them before what else the machine does."""
    if os.sched_getscheduler(0) != os.SCHED_FIFO:
        return
    os.sched_setscheduler(display.server.pid, os.SCHED_FIFO, os.sched_param(2))
    for thread in os.listdir(f'/proc/{process.pid}/task'):
        with open(f'/proc/{process.pid}/task/{thread}/comm', encoding='utf-8') as name:
            is_first = int(thread) == process.pid or 'llvmpipe' in name.read()
        os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(2 if is_first else 1))


class Display:
    """An X server of its own, gone with the `with` block."""

    def __init__(self, width=1280, height=800):
        self.size = f'{width}x{height}x24'

    def __enter__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(['Xvfb', '-displayfd', str(write), '-screen', '0', self.size, '-nolisten', 'tcp', '-noreset'],
                                       pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as said:
            self.name = ':' + said.readline().strip()
        if self.name == ':':
            raise RuntimeError('Xvfb did not start')
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()


class Hand:
    """Events by XTEST, without a process for each."""

    def __init__(self, display):
        self.x11, self.test = ctypes.CDLL('libX11.so.6'), ctypes.CDLL('libXtst.so.6')
        self.x11.XOpenDisplay.restype = ctypes.c_void_p
        self.x11.XStringToKeysym.restype = ctypes.c_ulong
        self.display = ctypes.c_void_p(self.x11.XOpenDisplay(display.name.encode()))
        self.sent = 0

    def move(self, x, y):
        self.test.XTestFakeMotionEvent(self.display, -1, x, y, ctypes.c_ulong(0))
        self.sent += 1

    def button(self, button, down):
        self.test.XTestFakeButtonEvent(self.display, button, int(down), ctypes.c_ulong(0))
        self.sent += 1

    def code(self, name):
        """The number of a key, and whether it needs Shift."""
        self.x11.XkbKeycodeToKeysym.restype = ctypes.c_ulong
        symbol = self.x11.XStringToKeysym({'ctrl': 'Control_L', 'shift': 'Shift_L', 'alt': 'Alt_L'}.get(name, name).encode())
        code = self.x11.XKeysymToKeycode(self.display, ctypes.c_ulong(symbol))
        return code, self.x11.XkbKeycodeToKeysym(self.display, code, 0, 0) != symbol

    def key(self, name):
        """A key by itself or with others ('ctrl+z'), pressed and let go."""
        codes = []
        for part in name.split('+'):
            code, needs_shift = self.code(part)
            codes += [self.code('shift')[0], code] if needs_shift else [code]
        for code, down in [(code, 1) for code in codes] + [(code, 0) for code in reversed(codes)]:
            self.test.XTestFakeKeyEvent(self.display, code, down, ctypes.c_ulong(0))
            self.sent += 1
        self.flush()  # a key that load keeps down is repeated
        time.sleep(0.005)  # GLFW takes a key once in a millisecond: input methods send some events twice

    def flush(self):
        self.x11.XSync(self.display, 0)

    def pixels(self, width, height):
        """Of the screen's upper left corner: four bytes each, blue first, rows from the top."""
        class Image(ctypes.Structure):
            _fields_ = [('width', ctypes.c_int), ('height', ctypes.c_int), ('offset', ctypes.c_int), ('format', ctypes.c_int),
                        ('data', ctypes.c_void_p), ('orders', ctypes.c_int * 5), ('row_bytes', ctypes.c_int)]
        x11 = self.x11
        x11.XGetImage.restype = ctypes.POINTER(Image)
        x11.XDefaultRootWindow.restype = ctypes.c_ulong
        every_plane, in_pixels = ctypes.c_ulong(2**64 - 1), 2
        root = ctypes.c_ulong(x11.XDefaultRootWindow(self.display))
        image = x11.XGetImage(self.display, root, 0, 0, width, height, every_plane, in_pixels)
        assert image and image.contents.row_bytes == 4 * width
        found = ctypes.string_at(image.contents.data, 4 * width * height)
        x11.XDestroyImage(image)
        return found


class Window:
    """`sluice view ARGUMENTS`, and what its log says."""

    def __init__(self, display, program, arguments, folder, environment=None):
        self.hand = Hand(display)
        self.log = pathlib.Path(folder, 'window.log')
        self.log.unlink(missing_ok=True)
        self.environment = dict(os.environ, DISPLAY=display.name, XDG_CONFIG_HOME=f'{folder}/config',
                                XDG_CACHE_HOME=f'{folder}/cache', LIBGL_ALWAYS_SOFTWARE='1', **(environment or {}))
        self.environment.pop('WAYLAND_DISPLAY', None)
        # Of who sends its events: nothing is put under that.
        self.outside = {name: value for name, value in self.environment.items() if name != 'LD_PRELOAD'}
        self.output = open(pathlib.Path(folder, 'window.out'), 'w+', encoding='utf-8')
        self.process = subprocess.Popen([program, 'view', *arguments, '--log', str(self.log)], cwd=folder, env=self.environment,
                                        stdout=self.output, stderr=subprocess.STDOUT)
        self.lines = []
        self.read_bytes = 0
        self.controls = {}
        self.echoes = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.output.close()

    def said(self):
        self.output.flush()
        return pathlib.Path(self.output.name).read_text(encoding='utf-8')

    def update(self):
        if not self.log.exists():
            return
        with open(self.log, encoding='utf-8') as file:
            file.seek(self.read_bytes)
            text = file.read()
        whole = text[:text.rfind('\n') + 1]
        self.read_bytes += len(whole.encode())
        for line in map(json.loads, whole.splitlines()):
            self.lines.append(line)
            if 'control' in line:
                self.controls[line['control']] = line['at']

    def wait(self, what, *, since=0):
        """The first line from number `since` on that `what` (a key, or a function of the line) is true of. Waits as long as the
        window lives: on a busy machine nobody knows how long it takes. What it waits for is printed now and then, so that one can
        read it where the test is ended for taking too long."""
        test = what if callable(what) else (lambda line: what in line)
        tell_at = time.monotonic() + TELL_SECONDS
        while True:
            self.update()
            for line in self.lines[since:]:
                if test(line):
                    return line
            if self.process.poll() is not None:
                raise RuntimeError(f'the window ended with {self.process.returncode}: {self.said()}')
            if time.monotonic() > tell_at:
                tell_at += TELL_SECONDS
                print(f'waiting for {what}; last lines {self.lines[-5:]}; said {self.said()}', flush=True)
            time.sleep(0.01)

    def mark(self):
        self.update()
        return len(self.lines)

    def whole(self, since):
        """Waits for a complete picture of the newest wish."""
        return self.wait(lambda line: line.get('complete') is True and line.get('of_newest'), since=since)

    def echo(self):
        """Waits until the window has taken all events that were sent, in their order, and shows what came of them."""
        self.echoes += 1
        self.hand.key('F12')
        self.wait(lambda line: line.get('echo', 0) >= self.echoes)

    def settled(self):
        """Waits until all events that were sent are taken, and until a complete picture of what they led to is on the
        screen: a drag has complete pictures of its way, too."""
        self.echo()

        def is_last(line):
            wish = next((line for line in reversed(self.lines) if 'wish' in line), None)
            return line.get('complete') is True and wish is not None and not wish['moves'] and line['picture'] == wish['wish']
        self.wait(is_last)
        self.echo()  # the window has sent that picture to the screen

    def do(self, *words):
        subprocess.run(['xdotool', *map(str, words)], env=self.outside, check=True, stdout=subprocess.DEVNULL)

    def stand_still(self, seconds=0.6):
        """Waits until no control has moved for so long: a window that has just opened gets its size late, and later if other
        programs keep it waiting."""
        before = None
        while self.controls != before:
            before = dict(self.controls)
            self.do('sleep', seconds)
            self.update()

    def find(self, title):
        """The number of a window of this title."""
        found = subprocess.run(['xdotool', 'search', '--sync', '--name', f'^{title}$'], env=self.outside, check=True,
                               stdout=subprocess.PIPE, text=True)
        return found.stdout.split()[0]

    def size(self, number):
        said = subprocess.run(['xdotool', 'getwindowgeometry', '--shell', number], env=self.outside, check=True,
                              stdout=subprocess.PIPE, text=True).stdout
        values = dict(line.split('=') for line in said.split())
        return int(values['WIDTH']), int(values['HEIGHT'])

    def place(self, control, x=0.5, y=0.5):
        """Of the middle of a control, or another part of it, once it is shown and where it is after the last events."""
        self.wait(lambda line: line.get('control') == control)
        self.echo()
        at = self.controls[control]
        return round(at[0] + x * at[2]), round(at[1] + y * at[3])

    def click(self, control, button=1, x=0.5, y=0.5, times=1):
        at = self.place(control, x, y)
        self.do('mousemove', *at, 'sleep', 0.1)
        for _ in range(times):  # sent at once: clicks that load draws apart are not double
            self.hand.button(button, True)
            self.hand.button(button, False)
        self.hand.flush()
        self.do('sleep', 0.1)

    def drag(self, start, end, button=1, steps=20, pause=0.016, keys=()):
        self.do('mousemove', *start, 'sleep', 0.1)
        for key in keys:
            self.do('keydown', key)
        words = ['mousedown', button, 'sleep', 0.05]
        for i in range(1, steps + 1):
            part = i / steps
            words += ['mousemove', *(round(a + (b - a) * part) for a, b in zip(start, end)), 'sleep', pause]
        self.do(*words, 'mouseup', button)
        for key in keys:
            self.do('keyup', key)

    def key(self, *keys):
        """Keys with the pointer over the picture."""
        self.hand.move(*self.place('picture', 0.5, 0.4))
        self.press(*keys)

    def press(self, *keys):
        """Keys where the pointer and the focus are."""
        for key in keys:
            self.hand.key(key)

    def fill(self, field, text):
        """Types into a field of text, in place of what is in it."""
        self.click(field, x=0.2)
        self.press('ctrl+a')
        self.do('type', '--delay', 12, text)
        self.do('sleep', 0.1)
        self.press('Return')

    def end(self):
        """Closes it by its key; the measured times."""
        self.key('ctrl+q')
        while self.process.poll() is None:
            try:
                self.process.wait(TELL_SECONDS)
            except subprocess.TimeoutExpired:
                print(f'waiting for the window to end; said {self.said()}', flush=True)
        self.update()
        if self.process.returncode != 0:
            raise RuntimeError(f'the window ended with {self.process.returncode}: {self.said()}')
        return next(line for line in self.lines if 'end' in line)

    def shot(self, name):
        """A screenshot in the folder $SLUICE_SCREENSHOTS, where there is one, for those who look at the tests' windows."""
        if folder := os.environ.get('SLUICE_SCREENSHOTS'):
            self.screenshot(pathlib.Path(folder, name + '.png'))

    def screenshot(self, path):
        """All of the screen, PNG; needs ImageMagick's import or xwd with OpenImageIO; False where there is none."""
        if shutil.which('import'):
            return subprocess.run(['import', '-window', 'root', str(path)], env=self.outside, check=False).returncode == 0
        return False

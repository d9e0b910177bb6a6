"""Drops files on a window as a file manager does: a source of X's drag and drop (XDND, version 5) by ctypes on libX11."""
import ctypes
import time
import urllib.parse

CLIENT_MESSAGE, SELECTION_REQUEST, SELECTION_NOTIFY = 33, 30, 31
LONG = ctypes.c_long


class ClientMessage(ctypes.Structure):
    _fields_ = [('type', ctypes.c_int), ('serial', ctypes.c_ulong), ('send_event', ctypes.c_int), ('display', ctypes.c_void_p),
                ('window', ctypes.c_ulong), ('message_type', ctypes.c_ulong), ('format', ctypes.c_int), ('data', LONG * 5)]


class SelectionRequest(ctypes.Structure):
    _fields_ = [('type', ctypes.c_int), ('serial', ctypes.c_ulong), ('send_event', ctypes.c_int), ('display', ctypes.c_void_p),
                ('owner', ctypes.c_ulong), ('requestor', ctypes.c_ulong), ('selection', ctypes.c_ulong), ('target', ctypes.c_ulong),
                ('property', ctypes.c_ulong), ('time', ctypes.c_ulong)]


class Selection(ctypes.Structure):
    _fields_ = [('type', ctypes.c_int), ('serial', ctypes.c_ulong), ('send_event', ctypes.c_int), ('display', ctypes.c_void_p),
                ('requestor', ctypes.c_ulong), ('selection', ctypes.c_ulong), ('target', ctypes.c_ulong), ('property', ctypes.c_ulong),
                ('time', ctypes.c_ulong)]


class Event(ctypes.Union):
    _fields_ = [('type', ctypes.c_int), ('client', ClientMessage), ('request', SelectionRequest), ('selection', Selection),
                ('pad', LONG * 24)]


def drop(display_name, window, paths, seconds=10):
    """Drops the files on the window (an X id); True when it says that it took them."""
    x11 = ctypes.CDLL('libX11.so.6')
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XInternAtom.restype = x11.XCreateSimpleWindow.restype = x11.XDefaultRootWindow.restype = ctypes.c_ulong
    display = ctypes.c_void_p(x11.XOpenDisplay(display_name.encode()))
    word = ctypes.c_ulong

    def atom(name):
        return x11.XInternAtom(display, name.encode(), 0)

    source = x11.XCreateSimpleWindow(display, word(x11.XDefaultRootWindow(display)), 0, 0, 1, 1, 0, word(0), word(0))
    selection, uris = atom('XdndSelection'), atom('text/uri-list')
    x11.XSetSelectionOwner(display, word(selection), word(source), word(0))
    text = ''.join('file://' + urllib.parse.quote(str(path)) + '\r\n' for path in paths).encode()

    def send(name, *data):
        event = Event()
        event.client.type = CLIENT_MESSAGE
        event.client.window, event.client.message_type, event.client.format = window, atom(name), 32
        event.client.data = (LONG * 5)(source, *data)
        x11.XSendEvent(display, word(window), 0, LONG(0), ctypes.byref(event))
        x11.XFlush(display)

    def answer(request):
        x11.XChangeProperty(display, word(request.requestor), word(request.property), word(request.target), 8, 0, text, len(text))
        event = Event()
        event.selection.type = SELECTION_NOTIFY
        for field in ('requestor', 'selection', 'target', 'property', 'time'):
            setattr(event.selection, field, getattr(request, field))
        x11.XSendEvent(display, word(request.requestor), 0, LONG(0), ctypes.byref(event))
        x11.XFlush(display)

    send('XdndEnter', 5 << 24, uris, 0, 0)
    send('XdndPosition', 0, (100 << 16) | 100, 0, atom('XdndActionCopy'))
    has_dropped, until = False, time.monotonic() + seconds
    event = Event()
    try:
        while time.monotonic() < until:
            if not x11.XPending(display):
                time.sleep(0.01)
                continue
            x11.XNextEvent(display, ctypes.byref(event))
            if event.type == SELECTION_REQUEST:
                answer(event.request)
            elif event.type == CLIENT_MESSAGE and event.client.message_type == atom('XdndStatus') and not has_dropped:
                has_dropped = bool(event.client.data[1] & 1)
                if not has_dropped:
                    return False
                send('XdndDrop', 0, 0, 0, 0)
            elif event.type == CLIENT_MESSAGE and event.client.message_type == atom('XdndFinished'):
                return event.client.data[1] != 0  # GLFW puts the bytes that it took there
        return False
    finally:
        x11.XCloseDisplay(display)

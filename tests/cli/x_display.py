# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""An X server without a screen (Xvfb), what it shows, and events for its windows, with libX11 alone."""
import contextlib
import ctypes
import pathlib
import shutil
import signal
import struct
import subprocess
import time


def missing():
    """Why there can be no such server here; empty when there can."""
    if not shutil.which("Xvfb"):
        return "Xvfb is not installed"
    try:
        ctypes.CDLL("libX11.so.6")
    except OSError:
        return "libX11.so.6 is not installed"
    return ""


class KeyEvent(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("window", ctypes.c_ulong), ("root", ctypes.c_ulong), ("subwindow", ctypes.c_ulong), ("time", ctypes.c_ulong),
                ("x", ctypes.c_int), ("y", ctypes.c_int), ("x_root", ctypes.c_int), ("y_root", ctypes.c_int),
                ("state", ctypes.c_uint), ("keycode", ctypes.c_uint), ("same_screen", ctypes.c_int)]


class MessageEvent(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("window", ctypes.c_ulong), ("message_type", ctypes.c_ulong), ("format", ctypes.c_int), ("data", ctypes.c_long * 5)]


class Event(ctypes.Union):
    _fields_ = [("key", KeyEvent), ("message", MessageEvent), ("pad", ctypes.c_long * 24)]


KEY_PRESS, KEY_RELEASE, CLIENT_MESSAGE = 2, 3, 33


class Display:
    """Use as a context: the server ends with it."""

    def __init__(self, folder, width=800, height=600):
        self.buffer = pathlib.Path(folder) / "Xvfb_screen0"
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", "1", "-screen", "0", f"{width}x{height}x24", "-fbdir", str(folder), "-nolisten", "tcp"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        number = self.server.stdout.readline().decode().strip()
        if not number:
            raise RuntimeError("Xvfb did not start")
        self.name = f":{number}"
        x = self.x = ctypes.CDLL("libX11.so.6")
        for function in ("XOpenDisplay", "XDefaultRootWindow", "XInternAtom", "XStringToKeysym"):
            getattr(x, function).restype = ctypes.c_void_p if function == "XOpenDisplay" else ctypes.c_ulong
        self.connection = ctypes.c_void_p(x.XOpenDisplay(self.name.encode()))
        self.root = ctypes.c_ulong(x.XDefaultRootWindow(self.connection))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.x.XCloseDisplay(self.connection)
        self.server.send_signal(signal.SIGTERM)
        self.server.wait()
        self.server.stdout.close()

    def window(self, program, seconds=120):
        """The window of a program, once it is there; before the program's name its title may tell the open file."""
        name = ctypes.c_char_p()
        root, parent, count = ctypes.c_ulong(), ctypes.c_ulong(), ctypes.c_uint()
        children = ctypes.POINTER(ctypes.c_ulong)()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.x.XQueryTree(self.connection, self.root, ctypes.byref(root), ctypes.byref(parent),
                              ctypes.byref(children), ctypes.byref(count))
            for child in children[:count.value]:
                self.x.XFetchName(self.connection, ctypes.c_ulong(child), ctypes.byref(name))
                if name.value and name.value.endswith(program):
                    return ctypes.c_ulong(child)
            time.sleep(0.05)
        raise RuntimeError("no window appeared")

    def send(self, window, event, mask):
        self.x.XSendEvent(self.connection, window, 0, ctypes.c_long(mask), ctypes.byref(event))
        self.x.XFlush(self.connection)

    def press(self, window, name, control=False):
        code = self.x.XKeysymToKeycode(self.connection, ctypes.c_ulong(self.x.XStringToKeysym(name.encode())))
        for kind in (KEY_PRESS, KEY_RELEASE):
            event = Event()
            event.key = KeyEvent(type=kind, display=self.connection, window=window.value, root=self.root.value, keycode=code & 0xff,
                                 state=4 if control else 0,
                                 same_screen=1, time=int(1000 * time.monotonic()))
            self.send(window, event, 3)
            time.sleep(0.2)

    def resize(self, window, width, height):
        self.x.XResizeWindow(self.connection, window, width, height)
        self.x.XFlush(self.connection)

    def close(self, window):
        """As the cross in a window's corner does."""
        atom = lambda name: self.x.XInternAtom(self.connection, name, 0)
        event = Event()
        event.message = MessageEvent(type=CLIENT_MESSAGE, display=self.connection, window=window.value,
                                     message_type=atom(b"WM_PROTOCOLS"), format=32)
        event.message.data[0] = atom(b"WM_DELETE_WINDOW")
        self.send(window, event, 0)

    def shown(self):
        """(width, height, bytes of four a pixel) of the whole screen: the server's own memory, a file of xwd."""
        data = self.buffer.read_bytes()
        head = struct.unpack_from(">25I", data)
        begin = head[0] + 12 * head[19]
        return head[4], head[5], data[begin:begin + head[5] * head[12]]

    def wait_for(self, test, what, seconds=120):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            shown = self.shown()
            if test(*shown):
                return shown
            time.sleep(0.1)
        raise AssertionError(f"{what} within {seconds} s")


@contextlib.contextmanager
def running(program, display, environment, folder):
    """A program on the display; stopped with the context if it still runs."""
    process = subprocess.Popen(list(map(str, program)), env=environment | {"DISPLAY": display.name}, cwd=folder,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()
        process.stderr.close()

"""A screen without a monitor (Xvfb) with trevi-view on it: keys and mouse through xdotool, pictures as arrays.

Needs Xvfb, xdotool, numpy and Pillow. All waiting is for conditions, as the machine may be busy.
"""

import os
import re
import subprocess
import time

import numpy
from PIL import ImageGrab

from runs import PROGRAM, environment

VIEW = os.environ.get("TREVI_VIEW", PROGRAM + "-view")
PATIENCE = 60  # s; for one condition
SIZE = (480, 360)
STATUS_ROWS = 60  # pixels at the bottom that hold the status line


def wait_until(condition, what, process=None):
    end = time.monotonic() + PATIENCE
    while True:
        value = condition()
        if value:
            return value
        if process is not None and process.poll() is not None:
            raise AssertionError(f"trevi-view ended with {process.returncode} before {what}")
        if time.monotonic() > end:
            raise AssertionError(f"waited in vain for {what}")
        time.sleep(0.02)


class Screen:
    def __init__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1024x768x24", "-noreset"],
                                       pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as pipe:
            self.display = ":" + pipe.readline().strip()

    def close(self):
        self.server.terminate()
        self.server.wait()

    def environment(self):
        return {**environment(), "DISPLAY": self.display, "LIBGL_ALWAYS_SOFTWARE": "1"}

    def do(self, *words):
        return subprocess.run(["xdotool", *map(str, words)], env=self.environment(), capture_output=True, text=True,
                              check=False).stdout.strip()


class Viewer:
    """A trevi-view in a window, and what one can do with it."""

    def __init__(self, screen, *arguments, folder=None, path=None):
        """`path`: where programs that play music are looked for; silent without it."""
        self.screen = screen
        words = [VIEW, *arguments, "--size", SIZE[0], SIZE[1], *([] if path else ["--mute"])]
        self.process = subprocess.Popen([str(word) for word in words], cwd=folder,
                                        env={**screen.environment(), **({"PATH": str(path)} if path else {})},
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        find = ["search", "--onlyvisible", "--name", "^trevi-view: "]
        self.window = wait_until(lambda: screen.do(*find), "the window", self.process).split()[0]
        self.do("mousemove", "--window", self.window, SIZE[0] // 2, SIZE[1] // 2)  # keys go where the mouse is

    def do(self, *words):
        return self.screen.do(*words)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def title(self):
        return self.do("getwindowname", self.window)

    def step(self):
        found = re.search(r"step (\d+)", self.title())
        return int(found[1]) if found else -1

    def wait_title(self, pattern):
        return wait_until(lambda: re.search(pattern, self.title()), f"the title to say {pattern}", self.process)

    def press(self, key, pattern=None):
        self.do("key", key)
        if pattern:
            self.wait_title(pattern)

    def drag(self, dx, dy):
        x, y = SIZE[0] // 2, SIZE[1] // 2
        self.do("mousemove", "--window", self.window, x, y, "mousedown", 1)
        for part in (0.25, 0.5, 0.75, 1):
            self.do("mousemove", "--window", self.window, round(x + part * dx), round(y + part * dy))
        self.do("mouseup", 1, "mousemove", "--window", self.window, x, y)

    def grab(self):
        """The window's pixels, the status line left out."""
        image = ImageGrab.grab(xdisplay=self.screen.display)
        geometry = dict(line.split("=") for line in self.do("getwindowgeometry", "--shell", self.window).splitlines())
        x, y = int(geometry["X"]), int(geometry["Y"])
        return numpy.asarray(image)[y:y + SIZE[1] - STATUS_ROWS, x:x + SIZE[0], :3].astype(int)

    def settled(self):
        """The picture once it does not change any more."""
        last = [self.grab()]

        def same():
            time.sleep(0.15)
            last.append(self.grab())
            return last[-1] if (last[-1] == last[-2]).all() else None

        return wait_until(lambda: None if (image := same()) is None else [image], "a picture at rest", self.process)[0]


def water(image):
    """Which pixels are coloured: the background, the box and its floor are almost grey."""
    return image.max(axis=2) - image.min(axis=2) > 60


def like(image, colour):
    """How many pixels have this colour, brighter or darker."""
    brightest = image.max(axis=2, keepdims=True)
    same = numpy.abs(image / numpy.maximum(brightest, 1) - numpy.array(colour) / max(colour)).max(axis=2) < 0.04
    return (same & (brightest[:, :, 0] > 50)).sum()


def changed(one, other):
    """The share of water pixels that differ."""
    return (numpy.abs(one - other).max(axis=2) > 20).sum() / max(1, water(one).sum())
